// tests/jobs/pass_surfaces.h: stores of one surface, in one piece and in shards, and passes over
// them, in parts and in one process.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>

#include "conversion/conversion_job.h"
#include "engine/store/format_reader.h"
#include "io/file_operations.h"
#include "plait/digest.h"
#include "plait/extend/check_store.h"
#include "plait/extend/parts.h"
#include "plait/extend/pass.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "plait/visit_vertices.h"
#include "support/file_bytes.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test::passes {

namespace fs = std::filesystem;
using Point = Vector3<float>;

/// Stores of one surface, in one piece and in shards.
struct Surfaces {
  fs::path mesh, directory;
  int levels = 3;
  bool normals = false, limit = false;
  Scheme scheme = {};
  ComponentType precision = ComponentType::kFloat32;
  std::optional<std::uint64_t> max_slot_bytes = 100;  // refines the base mesh in memory
  PipelinesOf pipeline_of = {};

  fs::path whole() const { return directory / "whole.plait"; }
  fs::path sharded() const { return directory / "s.plait"; }

  /// By one process. Returns the digest.
  std::string make_whole() const {
    const SubdivisionRequest request{.mesh = mesh,
                                     .store = whole(),
                                     .levels = levels,
                                     .backend = "pread",
                                     .layout = LayoutKind::kHilbert,
                                     .scheme = scheme,
                                     .precision = precision,
                                     .block_bytes = 4 << 10,
                                     .max_slot_bytes = max_slot_bytes,
                                     .normals = normals,
                                     .limit = limit,
                                     .digest = true};
    return SubdivisionJob(request, default_backends()).run().digest;
  }
  PartsRequest request(std::uint32_t parts, const std::string& name = "shards") const {
    return {.mesh = mesh,
            .plan = directory / name,
            .parts = parts,
            .levels = levels,
            .scheme = scheme,
            .precision = precision,
            .normals = normals,
            .limit = limit,
            .block_bytes = 4 << 10,
            .max_slot_bytes = max_slot_bytes,
            .pipeline_of = pipeline_of};
  }
  fs::path plan_shards(std::uint32_t parts, const std::string& name = "shards") const {
    plan_parts(request(parts, name), default_backends());
    return directory / name;
  }
  void make_shards(std::uint32_t parts) const {
    const fs::path shards = plan_shards(parts);
    for (std::uint32_t part = 0; part < parts; ++part)
      make_part(shards, part, {}, default_backends());
    REQUIRE(join_parts(shards, sharded(), {}, default_backends()).has_store);
    fs::remove_all(shards);
  }
  fs::path plan(const Pass& pass, const std::string& name = "plan") const {
    const PassRequest request{.store = sharded(), .plan = directory / name, .pass = pass};
    plan_pass(request, default_backends());
    return request.plan;
  }
};

inline Surfaces surfaces_of(const fs::path& directory, const IndexedMesh& mesh) {
  const Surfaces made{.mesh = directory / "mesh.ply", .directory = directory};
  write_ply(made.mesh, mesh);
  return made;
}

inline void make_parts(const fs::path& plan, const Pass& pass = {}, int threads = 1) {
  // The last part first: no part needs another one.
  for (auto part = static_cast<std::uint32_t>(read_parts_plan(plan).parts.size()); part-- > 0;)
    make_part(plan, part, {.threads = threads, .kernel = pass.kernel}, default_backends());
}

inline JoinResult join(const fs::path& plan, const fs::path& store,
                       const JoinOptions& options = {}) {
  return join_parts(plan, store, options, default_backends());
}

/// One plan of a pass, in parts.
inline void pass_in_parts(const Surfaces& on, const Pass& pass, int threads = 1) {
  const fs::path plan = on.plan(pass, "one.pass");
  make_parts(plan, pass, threads);
  REQUIRE(join(plan, on.sharded(), {.verify = true}).has_store);
  fs::remove_all(plan);
}

inline std::string digest_of(const fs::path& store) {
  return digest(Store::open(store, {}, default_backends())).to_string();
}

inline Store open_to_write(const fs::path& store) {
  return Store::open(store, {.writable = true}, default_backends());
}

/// The files of a store that say nothing of its UUID: levels and base records.
inline std::map<std::string, std::string> record_files(const fs::path& store) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(store))
    if (const std::string name = entry.path().filename();
        name.starts_with("attribute") || name == "base.mesh")
      files[name] = content_of(entry.path());
  return files;
}

/// The record_files() of a copy in one piece.
inline std::map<std::string, std::string> converted(const fs::path& from) {
  const fs::path to = from.native() + ".copy";
  convert({.from = from, .to = to}, default_backends(), default_backends(), {});
  const auto files = record_files(to);
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

/// A reader that was written from docs/format.md alone finds the same in both.
inline void check_by_format(const fs::path& sharded, const fs::path& whole) {
  const format::Store shards = format::read_store(sharded), one = format::read_store(whole);
  REQUIRE(shards.attributes.size() == one.attributes.size());
  for (std::size_t at = 0; at < one.attributes.size(); ++at) {
    CHECK(shards.attributes[at].levels == one.attributes[at].levels);
    CHECK(shards.attributes[at].base == one.attributes[at].base);
  }
}

/// The store in shards has these records, and no other file than it should.
inline void check_records(const Surfaces& on, const Expected& expected) {
  CHECK(digest_of(on.sharded()) == expected.digest);
  CHECK(converted(on.sharded()) == expected.files);
  const StoreCheck check = check_store(on.sharded(), default_backends());
  CHECK(check.damaged.empty());
  CHECK(check.left_over.empty());
  check_by_format(on.sharded(), on.whole());
}

/// Something that no pass of the library makes: it needs the number of a vertex, a ring, and an
/// attribute beside the positions.
inline Pass own_pass() {
  Pass pass{.name = "relief", .result = schema_of<float>("relief"), .parameters = "weight 2"};
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

/// Makes part 1 of a plan, and checks which paths its file operations change.
inline void check_that_a_part_changes_only_its_files(const fs::path& plan) {
  struct ChangedPaths final : FileOperationHook {
    ChangedPaths() { set_file_operation_hook(this); }
    ~ChangedPaths() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation& operation) noexcept override {
      if (is_harmless(operation.kind)) return {};
      const std::scoped_lock lock(mutex);
      paths.insert(operation.path);
      if (operation.to != nullptr) paths.insert(*operation.to);
      return {};
    }
    void after(const FileOperation&) noexcept override {}

    std::mutex mutex;
    std::set<fs::path> paths;
  } changed;
  make_part(plan, 1, {}, default_backends());
  REQUIRE_FALSE(changed.paths.empty());
  for (const fs::path& path : std::set<fs::path>(changed.paths)) {
    CAPTURE(path);
    const std::string name = path.lexically_relative(plan).native();
    CHECK((name.starts_with("part.1-") || name == "done.1" || name == "."));  // it syncs "."
  }
}

}  // namespace plait::test::passes
