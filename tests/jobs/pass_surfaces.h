// tests/jobs/pass_surfaces.h: stores of one surface, in one piece and in shards, and passes over
// them, in parts and in one process.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "conversion/conversion_job.h"
#include "engine/store/format_reader.h"
#include "plait/digest.h"
#include "plait/extend/check_store.h"
#include "plait/extend/parts.h"
#include "plait/extend/pass.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "plait/visit_vertices.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test::passes {

namespace fs = std::filesystem;
using Point = Vector3<float>;

/// Stores of one surface, in one piece and in shards.
struct Surfaces {
  fs::path mesh, directory;
  int levels = 3;
  bool normals = false;
  ComponentType precision = ComponentType::kFloat32;
  std::optional<std::uint64_t> max_slot_bytes = 100;  // refines the base mesh in memory
  PipelinesOf pipeline_of = {};

  fs::path whole() const { return directory / "whole.plait"; }
  fs::path sharded() const { return directory / "s.plait"; }

  void make_whole() const {
    SubdivisionRequest request;
    request.mesh = mesh;
    request.store = whole();
    request.levels = levels;
    request.normals = normals;
    request.precision = precision;
    request.max_slot_bytes = max_slot_bytes;
    request.block_bytes = 4 << 10;
    request.backend = "pread";
    request.layout = LayoutKind::kHilbert;
    SubdivisionJob(request, default_backends()).run();
  }
  fs::path plan_shards(std::uint32_t parts) const {
    PartsRequest request;
    request.mesh = mesh;
    request.plan = directory / "shards";
    request.parts = parts;
    request.levels = levels;
    request.normals = normals;
    request.precision = precision;
    request.max_slot_bytes = max_slot_bytes;
    request.block_bytes = 4 << 10;
    request.pipeline_of = pipeline_of;
    plan_parts(request, default_backends());
    return request.plan;
  }
  void make_shards(std::uint32_t parts) const {
    const fs::path shards = plan_shards(parts);
    for (std::uint32_t part = 0; part < parts; ++part)
      make_part(shards, part, {}, default_backends());
    REQUIRE(join_parts(shards, sharded(), {}, default_backends()).has_store);
    fs::remove_all(shards);
  }
  fs::path plan(const Pass& pass, const std::string& name = "plan") const {
    PassRequest request;
    request.store = sharded();
    request.plan = directory / name;
    request.pass = pass;
    plan_pass(request, default_backends());
    return request.plan;
  }
};

inline Surfaces surfaces_of(const fs::path& directory, const IndexedMesh& mesh) {
  Surfaces made;
  made.directory = directory;
  made.mesh = directory / "mesh.ply";
  write_ply(made.mesh, mesh);
  return made;
}

inline void make_parts(const fs::path& plan, const Pass& pass = {}, int threads = 1) {
  PartOptions options;
  options.threads = threads;
  options.kernel = pass.kernel;
  // The last part first: no part needs another one.
  for (auto part = static_cast<std::uint32_t>(read_parts_plan(plan).parts.size()); part-- > 0;)
    make_part(plan, part, options, default_backends());
}

inline JoinResult join(const fs::path& plan, const fs::path& store,
                       const JoinOptions& options = {}) {
  return join_parts(plan, store, options, default_backends());
}

/// One plan of a pass, in parts.
inline void pass_in_parts(const Surfaces& on, const Pass& pass, int threads = 1) {
  const fs::path plan = on.plan(pass, "one.pass");
  make_parts(plan, pass, threads);
  JoinOptions options;
  options.verify = true;
  REQUIRE(join(plan, on.sharded(), options).has_store);
  fs::remove_all(plan);
}

inline std::string digest_of(const fs::path& store) {
  return digest(Store::open(store, {}, default_backends())).to_string();
}

inline Store open_to_write(const fs::path& store) {
  OpenOptions options;
  options.writable = true;
  return Store::open(store, options, default_backends());
}

inline std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The files of a copy in one piece that say nothing of its UUID.
inline std::map<std::string, std::string> converted(const fs::path& from) {
  const fs::path to = from.native() + ".copy";
  ConversionRequest request;
  request.from = from;
  request.to = to;
  convert(request, default_backends(), default_backends(), {});
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(to))
    if (const std::string name = entry.path().filename();
        name.starts_with("attribute") || name == "base.mesh")
      files[name] = bytes_of(entry.path());
  fs::remove_all(to);
  return files;
}

/// A program's own smoothing, as simple as it can be: each vertex becomes the mean of its
/// neighbours' and its own position, on borders of those on the border.
inline void smooth_simply(Store& store, double factor) {
  store.add_attribute(schema_of<Point>("smoother"), store.finest_level());
  visit_vertices(store, {.name = "smooth"},
                 std::tuple{rings_of<Point>("position"), overwrites<Point>("smoother")},
                 [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
                   for (std::size_t i = 0; i < run.count; ++i) {
                     std::array<double, 3> sum{};
                     int count = 0;
                     for (int k = 0; k < ring.valence(); ++k) {
                       if (ring.is_border() && k != 0 && k != ring.valence() - 1) continue;
                       ++count;
                       const Point& at = ring.neighbour(i, k);
                       sum[0] += double{at.x};
                       sum[1] += double{at.y};
                       sum[2] += double{at.z};
                     }
                     const auto moved = [&](double from, double total) {
                       return static_cast<float>(from + factor * (1.0 / count * total - from));
                     };
                     const Point& from = ring.vertex(i);
                     to[i] = {moved(double{from.x}, sum[0]), moved(double{from.y}, sum[1]),
                              moved(double{from.z}, sum[2])};
                   }
                 });
  store.replace_attribute(store.attribute("position"), store.attribute("smoother"));
}

inline constexpr int kIterations = unless_sanitized(5, 2);
inline const Pass kSmooth{.name = "smooth", .factor = 0.4};

/// The digest and the files of one process's five iterations.
struct Expected {
  std::string digest;
  std::map<std::string, std::string> files;
};
inline Expected smoothed_by_one(const Surfaces& on, int iterations = kIterations) {
  on.make_whole();
  {
    Store store = open_to_write(on.whole());
    for (int pass = 0; pass < iterations; ++pass) smooth_simply(store, kSmooth.factor);
    store.commit();
  }
  return {digest_of(on.whole()), converted(on.whole())};
}

/// The store in shards has these records, and no other file than it should.
inline void check_records(const Surfaces& on, const Expected& expected) {
  CHECK(digest_of(on.sharded()) == expected.digest);
  CHECK(converted(on.sharded()) == expected.files);
  const StoreCheck check = check_store(on.sharded(), default_backends());
  CHECK(check.damaged.empty());
  CHECK(check.left_over.empty());
  // A reader that was written from docs/format.md alone finds the same.
  const format::Store shards = format::read_store(on.sharded()),
                      one = format::read_store(on.whole());
  REQUIRE(shards.attributes.size() == one.attributes.size());
  for (std::size_t at = 0; at < one.attributes.size(); ++at) {
    CHECK(shards.attributes[at].levels == one.attributes[at].levels);
    CHECK(shards.attributes[at].base == one.attributes[at].base);
  }
}

/// Something that no pass of the library makes: it needs the number of a vertex, a ring, and an
/// attribute beside the positions.
inline Pass own_pass() {
  Pass pass;
  pass.name = "relief";
  pass.result = schema_of<float>("relief");
  pass.parameters = "weight 2";
  pass.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(
        store, options,
        std::tuple{rings_of<Point>("position"), reads<Point>("normal"), overwrites<float>(into)},
        [](const VertexRun& run, const VertexRings<Point>& ring, std::span<const Point> normal,
           std::span<float> to) {
          for (std::size_t i = 0; i < run.count; ++i)
            to[i] = 2 * dot(ring.neighbour(i, 0) - ring.vertex(i), normal[i]) +
                    static_cast<float>((run.first + i) % 1000) + static_cast<float>(run.point(i).i);
        });
  };
  return pass;
}

inline fs::path directory_of(const fs::path& plan, std::uint32_t part) {
  for (const auto& entry : fs::directory_iterator(plan))
    if (entry.path().filename().native().starts_with("part." + std::to_string(part) + "-"))
      return entry.path();
  FAIL("part " << part << " has no directory");
  return {};
}

}  // namespace plait::test::passes
