// A visit of a store whose faces have depths of their own calls its kernel once for every vertex
// that a face has. Rings are those of an independent subdivision, at the finest level that all
// faces around the vertex have, and of one face for a vertex that only this face has on an edge.
#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "plait/detail/face_depths.h"
#include "plait/registry.h"
#include "plait/visit_vertices.h"
#include "support/error_of.h"
#include "support/naive_subdivision.h"
#include "support/random_depths.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "visit/batch_visit.h"

using namespace plait;
using namespace plait::test;

namespace {

using Id = std::uint32_t;
constexpr int kMost = 3;

/// A ring as a kernel gets it.
struct Found {
  std::vector<Id> neighbours;
  bool border = false;
  friend bool operator==(const Found&, const Found&) = default;
};
using RingsFound = std::map<Id, Found>;

/// What the rings must be, from naive meshes.
class DepthOracle {
 public:
  explicit DepthOracle(const IndexedMesh& mesh) {
    for (int level = 0; level <= kMost; ++level)
      levels_.push_back(naive::subdivide(to_naive(mesh), naive::Scheme::kMidpoint, level));
  }

  Id vertex(FaceId face, int level, std::int64_t i, std::int64_t j) const {
    return naive::vertex_at(levels_[static_cast<std::size_t>(level)], face, i, j);
  }

  RingsFound rings(const std::vector<std::uint8_t>& depths, int level) const {
    std::map<Id, std::set<FaceId>> around;  // faces that a vertex lies in, whether they have it
    for (FaceId face = 0; face < depths.size(); ++face)
      for (const Id vertex : naive::patch_vertices(levels_.back(), face))
        around[vertex].insert(face);
    const auto depth_of = [&](FaceId face) { return std::min<int>(depths[face], level); };
    const auto has = [&](int depth, Id vertex) {
      return vertex < levels_[static_cast<std::size_t>(depth)].points.size();
    };
    RingsFound expected;
    for (const auto& [vertex, faces] : around) {
      int common = kMost, deepest = 0;
      FaceId deep = 0;
      for (const FaceId face : faces) {
        common = std::min(common, depth_of(face));
        if (depth_of(face) >= deepest) {
          deepest = depth_of(face);
          deep = face;
        }
      }
      if (has(common, vertex))
        expected[vertex] = ring_in(levels_[static_cast<std::size_t>(common)], vertex);
      else if (has(deepest, vertex))
        expected[vertex] = ring_in(only(deep, deepest), vertex);
    }
    return expected;
  }

 private:
  static Found ring_in(const naive::Mesh& mesh, Id vertex) {
    const naive::Ring ring = naive::Rings(mesh).find(vertex);
    return {ring.neighbours, !ring.closed};
  }
  /// The mesh of one level with the triangles of one face alone.
  naive::Mesh only(FaceId face, int level) const {
    naive::Mesh mesh = levels_[static_cast<std::size_t>(level)];
    const std::size_t count = std::size_t{1} << (2 * level);
    const auto first = mesh.triangles.begin() + static_cast<std::ptrdiff_t>(face * count);
    mesh.triangles = {first, first + static_cast<std::ptrdiff_t>(count)};
    return mesh;
  }

  std::vector<naive::Mesh> levels_;  ///< [level]
};

struct Numbered {
  std::string backend = "memory";
  std::uint64_t block_bytes = 4096, budget_bytes = 64 << 20;
};

Store numbered_store(const std::filesystem::path& path, const BaseMesh& base, const Numbered& shape,
                     const DepthOracle& oracle) {
  const StoreOptions options{.backend = shape.backend,
                             .durability = Durability::kNone,
                             .block_bytes = shape.block_bytes,
                             .budget_bytes = shape.budget_bytes};
  Store store = Store::create(path, base, options, default_backends());
  const int finest = base.depths() ? base.depths()->deepest() : kMost;
  store.add_attribute(schema_of<Id>("id"), finest);
  store.add_attribute(schema_of<Id>("seen"), finest);
  visit_vertices(store, {}, std::tuple{overwrites<Id>("id")},
                 [&](const VertexRun& run, std::span<Id> id) {
                   for (std::size_t i = 0; i < run.count; ++i) {
                     const PatchPoint at = run.point(i);
                     int level = 0;
                     while (std::int64_t{1} << level < at.size) ++level;
                     id[i] = oracle.vertex(at.face, level, at.i, at.j);
                   }
                 });
  return store;
}

/// The rings of a visit, in the order that the kernel gets. Counts what is wrong: vertices that
/// come twice, and vertices whose records have other places in another attribute.
RingsFound visited_rings(Store& store, int level, int threads, int& wrong) {
  std::vector<std::vector<std::pair<Id, Found>>> by_worker(static_cast<std::size_t>(threads));
  const VisitOptions options{.level = level, .threads = threads};
  visit_vertices(store, options, std::tuple{rings_of<Id>("id"), overwrites<Id>("seen")},
                 [&](const VertexRun& run, const VertexRings<Id>& id, std::span<Id> seen) {
                   for (std::size_t i = 0; i < run.count; ++i) {
                     Found found{{}, id.is_border()};
                     for (int k = 0; k < id.valence(); ++k)
                       found.neighbours.push_back(id.neighbour(i, k));
                     seen[i] = id.vertex(i);
                     by_worker[static_cast<std::size_t>(run.worker)].emplace_back(id.vertex(i),
                                                                                  found);
                   }
                 });
  std::atomic<int> elsewhere = 0;
  visit_vertices(store, options, std::tuple{reads<Id>("id"), reads<Id>("seen")},
                 [&](const VertexRun& run, std::span<const Id> id, std::span<const Id> seen) {
                   for (std::size_t i = 0; i < run.count; ++i) elsewhere += id[i] != seen[i];
                 });
  wrong += elsewhere;
  RingsFound rings;
  for (const auto& of_worker : by_worker)
    for (const auto& [vertex, found] : of_worker) wrong += !rings.emplace(vertex, found).second;
  return rings;
}

/// The same rings in batches, which know no types.
RingsFound batched_rings(Store& store, int level, int& wrong) {
  RingsFound rings;
  const std::vector<BatchAttribute> attributes = {{"id", Access::kRead, true},
                                                  {"seen", Access::kRead, false}};
  visit_batches(store, {.level = level}, 0, attributes, [&](const VertexBatch& batch) {
    const auto* const id = reinterpret_cast<const Id*>(batch.attributes[0].records);
    const auto* const seen = reinterpret_cast<const Id*>(batch.attributes[1].records);
    const auto* neighbours = reinterpret_cast<const Id*>(batch.attributes[0].neighbours);
    for (std::size_t i = 0; i < batch.count; ++i, neighbours += batch.valence) {
      wrong += id[i] != seen[i];
      const Found found{{neighbours, neighbours + batch.valence}, batch.border};
      wrong += !rings.emplace(id[i], found).second;
    }
  });
  return rings;
}

/// Inside, the rings of the oracle begin at the smallest number.
RingsFound begun_at_smallest(RingsFound rings) {
  for (auto& [vertex, found] : rings)
    if (!found.border)
      std::ranges::rotate(found.neighbours, std::ranges::min_element(found.neighbours));
  return rings;
}

std::vector<std::uint8_t> depths_for(const BaseMesh& base, std::mt19937& random) {
  std::vector<std::uint8_t> depths = random_depths(base.face_count(), random, kMost);
  // Some face has all levels, so that levels mean the same for all depths.
  depths[random() % depths.size()] = kMost;
  return depths;
}

}  // namespace

TEST_CASE("VisitWithDepths_AllTestMeshes_GivesEachVertexOnceWithItsNaiveRing") {
  std::mt19937 random(1);
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() == 2 && named.mesh.positions.size() == 3)
      continue;  // two edges between the same vertices: the oracle cannot tell them apart
    const DepthOracle oracle(named.mesh);
    const BaseMesh base = BaseMesh::build(named.mesh);
    for (int trial = 0; trial < unless_sanitized(base.face_count() < 100 ? 6 : 2, 1); ++trial) {
      const std::vector<std::uint8_t> depths = depths_for(base, random);
      Store store = numbered_store({}, base.with_depths(depths), {}, oracle);
      const int level = static_cast<int>(random() % (kMost + 1));
      INFO(named.name << ", trial " << trial << ", level " << level);
      int wrong = 0;
      const RingsFound found = visited_rings(store, level, 1, wrong);
      CHECK(wrong == 0);
      CHECK((begun_at_smallest(found) == oracle.rings(depths, level)));
      CHECK((batched_rings(store, level, wrong) == found));
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("VisitWithDepths_WholeRings_BeginWhereThoseOfTheUniformStoreDo") {
  std::mt19937 random(2);
  const IndexedMesh mesh = random_sheet(8, 60);
  const DepthOracle oracle(mesh);
  const BaseMesh base = BaseMesh::build(mesh);
  const std::vector<std::uint8_t> depths = depths_for(base, random);
  int wrong = 0;
  Store uniform = numbered_store({}, base, {}, oracle);
  std::vector<RingsFound> by_level;
  for (int level = 0; level <= kMost; ++level)
    by_level.push_back(visited_rings(uniform, level, 1, wrong));
  Store store = numbered_store({}, base.with_depths(depths), {}, oracle);
  int whole = 0, with_base = 0;
  for (const auto& [vertex, found] : visited_rings(store, kMost, 1, wrong)) {
    const auto is_same = [&, &vertex = vertex, &found = found](const RingsFound& at_level) {
      const auto same = at_level.find(vertex);
      return same != at_level.end() && same->second == found;
    };
    if (found.border) continue;
    ++whole;
    with_base += vertex < mesh.positions.size();
    if (!std::ranges::any_of(by_level, is_same)) ++wrong;
  }
  CHECK(wrong == 0);
  CHECK(whole > 500);
  CHECK(with_base > 10);
}

TEST_CASE("VisitWithDepths_BackendsBudgetsAndThreads_GiveTheSameRings", "[threads]") {
  std::mt19937 random(3);
  const IndexedMesh mesh = random_sphere(9, unless_sanitized(300, 100));
  const DepthOracle oracle(mesh);
  const BaseMesh base = BaseMesh::build(mesh);
  // Few deep faces, far from each other: the edges of one fine block have many coarser blocks.
  std::vector<std::uint8_t> sparse(base.face_count(), 1);
  for (std::size_t face = 0; face < sparse.size(); face += 41) sparse[face] = kMost;
  for (const auto& depths : {depths_for(base, random), sparse}) {
    const RingsFound expected = oracle.rings(depths, kMost);
    for (const std::string backend : {"memory", "pread", "mmap", "compressed"})
      for (const int threads : {1, 3}) {
        CAPTURE(backend, threads);
        const TemporaryDirectory directory(Medium::kMemory);
        const auto path =
            backend == "memory" ? std::filesystem::path() : directory.path() / "s.plait";
        Store store = numbered_store(
            path, base.with_depths(depths),
            {.backend = backend, .block_bytes = 4096, .budget_bytes = 1 << 20}, oracle);
        int wrong = 0;
        CHECK((begun_at_smallest(visited_rings(store, kMost, threads, wrong)) == expected));
        CHECK(wrong == 0);
        CHECK_NOTHROW(store.commit());
      }
  }
}

TEST_CASE("VisitNeedsWithDepths_AsBudget_AreEnoughAndLessIsRefused") {
  const TemporaryDirectory directory(Medium::kMemory);
  const BaseMesh base = BaseMesh::build(shuffled(torus_grid(50, 60), 10));
  std::vector<std::uint8_t> depths(base.face_count(), 2);
  for (std::size_t face = 0; face < depths.size(); face += 97)
    depths[face] = 3;  // two fine blocks have all edges
  const auto path = directory.path() / "s.plait";
  const std::tuple ringed{rings_of<Id>("id"), overwrites<Id>("seen")};
  const auto add_ring = [](const VertexRun& run, const VertexRings<Id>& id, std::span<Id> seen) {
    for (std::size_t i = 0; i < run.count; ++i) {
      seen[i] = id.vertex(i);
      for (int k = 0; k < id.valence(); ++k) seen[i] += id.neighbour(i, k);
    }
  };
  std::uint64_t needed = 0;
  {
    Store store =
        Store::create(path, base.with_depths(depths),
                      {.durability = Durability::kNone, .block_bytes = 4096}, default_backends());
    for (const char* const name : {"id", "seen"}) store.add_attribute(schema_of<Id>(name), 3);
    visit_vertices(store, {}, std::tuple{overwrites<Id>("id")},
                   [](const VertexRun& run, std::span<Id> id) {
                     for (std::size_t i = 0; i < run.count; ++i)
                       id[i] = static_cast<Id>(run.first + i);
                   });
    needed = visit_needs(store, {}, ringed).frames;
    store.commit();
  }
  REQUIRE(needed >= 68 << 10);
  const auto open = [&](std::uint64_t budget) {
    const OpenOptions options{
        .writable = true, .durability = Durability::kNone, .budget_bytes = budget, .io_threads = 0};
    return Store::open(path, options, default_backends());
  };
  {
    Store store = open(needed - 4096);
    CHECK(error_of([&] { visit_vertices(store, {}, ringed, add_ring); }).code() ==
          ErrorCode::kBudget);
  }
  Store store = open(needed);
  CHECK_NOTHROW(visit_vertices(store, {}, ringed, add_ring));
  CHECK_NOTHROW(store.commit());
}
