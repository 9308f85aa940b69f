// A visit calls its kernel once for every vertex, base vertices too, with the neighbours that an
// independent subdivision finds; and its result does not depend on threads, blocks or budget.
#include "plait/visit_vertices.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/pager.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/error_of.h"
#include "support/naive_subdivision.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using VisitedPoint = Vector3<float>;
using Id = std::uint32_t;

Store visited_in_memory(const BaseMesh& base, int base_level = 0) {
  return Store::create({}, base, {.backend = "memory", .block_bytes = 4096}, default_backends(),
                       {.base_level = base_level});
}

naive::Mesh refined_to_visit(const IndexedMesh& mesh, int levels) {
  return naive::subdivide(to_naive(mesh), naive::Scheme::kMidpoint, levels);
}

/// Calls visit(record, number of the vertex in the oracle) for all vertices, some several times. It
/// uses the transparent executor, and so no code of the visit.
template <class Visit>
void for_each_numbered(Store& store, const char* attribute, const naive::Mesh& oracle, int level,
                       bool writes, Visit visit) {
  StorePatches<Id> patches(store, store.attribute(attribute), 1 << 24, Reach::kOwn);
  patches.activate(level, writes ? store.base_level() + 1 : 1, writes ? level : 0);
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const auto patch = patches.patch(face);
    const std::int64_t size = patch.size(level);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i)
        visit(patch.at(level, i, j), naive::vertex_at(oracle, face, i, j));
  }
}

/// Whether `found` is the ring of the oracle. The oracle's rings inside begin anywhere.
bool is_ring(std::vector<naive::Index> found, bool border, const naive::Ring& ring) {
  if (border == ring.closed || found.size() != ring.neighbours.size()) return false;
  if (ring.closed) std::ranges::rotate(found, std::ranges::min_element(found));
  return found == ring.neighbours;
}

/// Visits a store of `mesh` whose attribute "id" has the numbers of the oracle.
void check_visit(const IndexedMesh& mesh, int levels, int stored_levels, int base_level,
                 int threads) {
  const naive::Mesh oracle = refined_to_visit(mesh, levels);
  const naive::Rings rings(oracle);
  const BaseMesh base = BaseMesh::build(mesh);
  Store store = visited_in_memory(base, base_level);
  store.add_attribute(schema_of<Id>("id"), base_level + stored_levels);
  store.add_attribute(schema_of<Id>("seen"), base_level + stored_levels);
  const int level = base_level + levels;
  for_each_numbered(store, "id", oracle, level, true, [](Id& id, Id number) { id = number; });

  const VertexNumbering numbering(base.topology(), levels);
  std::vector<std::atomic<int>> visits(oracle.points.size()), by_number(oracle.points.size());
  std::atomic<int> wrong_rings = 0, wrong_runs = 0, wrong_points = 0;
  visit_vertices(store, {.level = level, .threads = threads},
                 std::tuple{rings_of<Id>("id"), overwrites<Id>("seen")},
                 [&](const VertexRun& run, const VertexRings<Id>& id, std::span<Id> seen) {
                   wrong_runs += seen.size() != run.count || run.worker >= threads;
                   wrong_runs += run.is_base() != (run.level == base_level);
                   for (std::size_t i = 0; i < run.count; ++i) {
                     const Id vertex = id.vertex(i);
                     std::vector<naive::Index> neighbours;
                     for (int k = 0; k < id.valence(); ++k)
                       neighbours.push_back(id.neighbour(i, k));
                     wrong_rings += !is_ring(neighbours, id.is_border(), rings.find(vertex));
                     ++visits[vertex];
                     ++by_number[numbering.first_of(run.level - base_level) + run.first + i];
                     seen[i] = vertex + 1;
                     const PatchPoint at = run.point(i);
                     const int refined = run.level - base_level;
                     wrong_points += at.size != std::int64_t{1} << refined ||
                                     numbering.number({at.face, refined, at.i, at.j}) !=
                                         numbering.first_of(refined) + run.first + i;
                   }
                 });
  CHECK(wrong_rings == 0);
  CHECK(wrong_runs == 0);
  CHECK(wrong_points == 0);
  CHECK(std::ranges::all_of(visits, [](const auto& count) { return count == 1; }));
  CHECK(std::ranges::all_of(by_number, [](const auto& count) { return count == 1; }));
  int wrong = 0;
  for_each_numbered(store, "seen", oracle, level, false,
                    [&](Id seen, Id number) { wrong += seen != number + 1; });
  CHECK(wrong == 0);
}

/// A step of smoothing with weights that no symmetry hides.
struct Smooth {
  void operator()(const VertexRun& run, const VertexRings<VisitedPoint>& at,
                  std::span<const float> weight, std::span<VisitedPoint> to) const {
    for (std::size_t i = 0; i < run.count; ++i) {
      VisitedPoint sum{};
      for (int k = 0; k < at.valence(); ++k) sum = sum + float(k + 1) * at.neighbour(i, k);
      to[i] = at.vertex(i) + weight[i] * sum;
    }
  }
};
const std::tuple kSmoothed{rings_of<VisitedPoint>("position"), reads<float>("weight"),
                           overwrites<VisitedPoint>("smooth")};

struct Shape {
  std::string backend = "memory";
  std::uint64_t block_bytes = 4096, budget_bytes = 64 << 20;
  int threads = 1;
  LayoutKind layout = LayoutKind::kGiven;
};

Store store_to_visit(const std::filesystem::path& path, const Shape& shape, int levels) {
  const StoreOptions options{.backend = shape.backend,
                             .durability = Durability::kNone,
                             .block_bytes = shape.block_bytes,
                             .budget_bytes = shape.budget_bytes};
  Store store =
      Store::create(path, lay_out(BaseMesh::build(random_sheet(7, 400)), shape.layout).mesh,
                    options, default_backends());
  add_base_positions(store);
  subdivide(store, {.executor = ExecutorKind::kTransparent, .levels = levels});
  store.add_attribute(schema_of<float>("weight"), levels);
  store.add_attribute(schema_of<VisitedPoint>("smooth"), levels);
  visit_vertices(
      store, {}, std::tuple{reads<VisitedPoint>("position"), overwrites<float>("weight")},
      [](const VertexRun& run, std::span<const VisitedPoint> at, std::span<float> weight) {
        for (std::size_t i = 0; i < run.count; ++i) weight[i] = 0.01f + at[i].x / 1024;
      });
  return store;
}

}  // namespace

TEST_CASE("VisitVertices_AllTestMeshes_GivesEachVertexOnceWithItsNaiveRing") {
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() == 2 && named.mesh.positions.size() == 3)
      continue;  // two edges between the same vertices: the oracle cannot tell them apart
    for (int levels = 0; levels <= 3; ++levels) {
      INFO(named.name << ", level " << levels);
      check_visit(named.mesh, levels, levels, 0, 1);
    }
  }
}

TEST_CASE("VisitVertices_SeveralThreads_GivesEachVertexOnceWithItsNaiveRing", "[threads]") {
  for (const IndexedMesh& mesh : {random_sphere(3, 500), random_sheet(4, 500)})
    for (const int threads : {2, 3}) check_visit(mesh, 3, 3, 0, threads);
}

TEST_CASE("VisitVertices_CoarserLevelOrRefinedBase_CountsLevelsAsTheStore") {
  check_visit(random_sheet(5, 60), 2, 4, 0, 1);
  check_visit(random_sheet(5, 60), 2, 2, 3, 1);
}

TEST_CASE("VisitVertices_BackendsBlocksBudgetsThreadsAndLayouts_GiveTheSameBits", "[threads]") {
  constexpr int kLevels = 4;
  std::string expected;
  std::vector<Shape> shapes = {{}};
  for (const std::string backend : {"pread", "mmap", "compressed"})
    for (const int threads : {1, 2})
      shapes.push_back({.backend = backend, .budget_bytes = 1 << 20, .threads = threads});
  shapes.push_back({.backend = "pread", .block_bytes = 1 << 16, .threads = 2});
  shapes.push_back({.backend = "memory", .threads = 3, .layout = LayoutKind::kHilbert});
  for (const Shape& shape : shapes) {
    CAPTURE(shape.backend, shape.block_bytes, shape.threads);
    const TemporaryDirectory directory(Medium::kMemory);
    Store store = store_to_visit(shape.backend == "memory" ? "" : directory.path() / "s.plait",
                                 shape, kLevels);
    visit_vertices(store, {.threads = shape.threads}, kSmoothed, Smooth());
    store.replace_attribute(store.attribute("position"), store.attribute("smooth"));
    visit_vertices(store, {.threads = shape.threads}, std::tuple{updates<VisitedPoint>("position")},
                   [](const VertexRun&, std::span<VisitedPoint> at) {
                     for (VisitedPoint& point : at) point = 2.0f * point;
                   });
    store.commit();
    const std::string found = digest(store).to_string();
    if (expected.empty()) expected = found;
    CHECK(found == expected);
  }
}

TEST_CASE("VisitNeeds_AsBudget_AreEnoughAndLessIsRefusedBeforeAnyChange") {
  const TemporaryDirectory directory(Medium::kMemory);
  const Shape shape{.backend = "pread"};
  const std::filesystem::path path = directory.path() / "s.plait";
  std::uint64_t needed = 0;
  {
    Store store = store_to_visit(path, shape, 5);
    needed = visit_needs(store, {.level = 5}, kSmoothed).frames;
    store.commit();
  }
  REQUIRE(needed > 128 << 10);
  const auto open = [&](std::uint64_t budget) {
    const OpenOptions options{
        .writable = true, .durability = Durability::kNone, .budget_bytes = budget, .io_threads = 0};
    return Store::open(path, options, default_backends());
  };
  {
    Store store = open(needed - 4096);
    const Error error = error_of([&] { visit_vertices(store, {}, kSmoothed, Smooth()); });
    INFO(error.what());
    CHECK(error.code() == ErrorCode::kBudget);
    CHECK_NOTHROW(store.commit());  // nothing is unfinished
  }
  Store store = open(needed);
  CHECK_NOTHROW(visit_vertices(store, {}, kSmoothed, Smooth()));
  CHECK_NOTHROW(store.commit());
}

TEST_CASE("VisitVertices_WithMoreThreadsThanTheBudgetHolds_TakesFewerAndSaysHowMany", "[threads]") {
  const TemporaryDirectory directory(Medium::kMemory);
  std::string expected;
  for (const auto& [budget, most] : {std::pair{2 << 20, 199}, std::pair{256 << 20, 200}}) {
    CAPTURE(budget);
    const Shape shape{.backend = "pread", .budget_bytes = static_cast<std::uint64_t>(budget)};
    Store store = store_to_visit(directory.path() / std::to_string(budget), shape, 6);
    int taken = 0;
    const VisitOptions options{.threads = 200, .begins = [&](int threads) { taken = threads; }};
    std::atomic<int> beyond = 0;
    visit_vertices(store, options, kSmoothed,
                   [&](const VertexRun& run, const VertexRings<VisitedPoint>& at,
                       std::span<const float> weight, std::span<VisitedPoint> to) {
                     beyond += run.worker >= taken;
                     Smooth()(run, at, weight, to);
                   });
    CHECK(beyond == 0);
    CHECK(taken > 1);
    CHECK((most == 200) == (taken == 200));
    const std::string found = digest(store).to_string();
    if (expected.empty()) expected = found;
    CHECK(found == expected);
    CHECK(StoreAccess::pager(store).budget_bytes() == static_cast<std::uint64_t>(budget));
  }
}

TEST_CASE("VisitVertices_Watched_TellsHowManyVerticesAreDone") {
  Store store = store_to_visit("", {}, 3);
  std::uint64_t last = 0, total = 0;
  bool ascends = true;
  VisitOptions options;
  options.progress = [&](const Progress& now) {
    ascends = ascends && now.done > last;
    last = now.done;
    total = now.total;
    return true;
  };
  visit_vertices(store, options, std::tuple{reads<VisitedPoint>("position")},
                 [](const VertexRun&, std::span<const VisitedPoint>) {});
  CHECK(ascends);
  CHECK(last == total);
  CHECK(total == counts_at_level(store.base(), 3).vertices);
}

TEST_CASE("VisitVertices_Cancelled_LeavesLevelsThatCannotBeCommitted") {
  Store store = store_to_visit("", {}, 3);
  VisitOptions options;
  options.progress = [](const Progress&) { return false; };
  const Error error = error_of([&] { visit_vertices(store, options, kSmoothed, Smooth()); });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
  visit_vertices(store, {}, kSmoothed, Smooth());
  CHECK_NOTHROW(store.commit());
}

TEST_CASE("VisitVertices_KernelThatThrowsInAnyThread_EndsWithOneOfItsExceptions", "[threads]") {
  for (const int threads : {1, 2}) {
    Store store = store_to_visit("", {}, 3);
    const auto throws = [](const VertexRun& run, const VertexRings<VisitedPoint>&,
                           std::span<const float>, std::span<VisitedPoint>) {
      if (!run.is_base()) throw std::out_of_range("from the kernel");
    };
    const VisitOptions options{.threads = threads};
    CHECK_THROWS_AS(visit_vertices(store, options, kSmoothed, throws), std::out_of_range);
    CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
    visit_vertices(store, options, kSmoothed, Smooth());
    CHECK_NOTHROW(store.commit());
  }
}

TEST_CASE("VisitNeeds_OfRings_AreAGridAndTwoRecordsForEachEdge") {
  Store store = store_to_visit("", {}, 3);
  EdgeGrid<VisitedPoint> grid;
  grid.resize(3);
  const std::uint64_t grid_points = grid.shape().point_count() + 1;
  for (const int threads : {1, 3}) {
    CHECK(visit_needs(store, {.threads = threads}, kSmoothed).resident ==
          sizeof(VisitedPoint) * (grid_points + 2 * store.base().edge_count()));
  }
  CHECK(visit_needs(store, {}, std::tuple{reads<VisitedPoint>("position")}).resident == 0);
}

TEST_CASE("VisitVertices_WhatCannotBe_IsRefusedInWords") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  Store store = store_to_visit(path, {.backend = "pread"}, 3);
  store.add_attribute(schema_of<float>("short"), 2);
  const auto nothing = [](const VertexRun&, auto&&...) {};
  const auto refused = [&](const VisitOptions& options, const auto& attributes, ErrorCode code,
                           const std::string& says, Store& of) {
    const Error error = error_of([&] { visit_vertices(of, options, attributes, nothing); });
    CHECK(error.code() == code);
    CHECK_THAT(error.what(), Catch::Contains(says));
  };
  const auto invalid = ErrorCode::kInvalidArgument;
  refused({}, std::tuple{rings_of<VisitedPoint>("position"), updates<VisitedPoint>("position")},
          invalid,
          "'position' is named twice: a pass that reads rings of an attribute writes to another",
          store);
  refused({}, std::tuple{reads<VisitedPoint>("positions")}, ErrorCode::kNotFound, "position",
          store);
  refused({}, std::tuple{reads<float>("position")}, invalid, "float32 x 3", store);
  refused({}, std::tuple{reads<VisitedPoint>("position"), overwrites<float>("short")}, invalid,
          "attribute 'position' has level 3 and attribute 'short' has level 2", store);
  refused({.level = 3}, std::tuple{overwrites<float>("short")}, invalid,
          "'short' ends at level 2: make it with Store::add_attribute(schema, 3)", store);
  refused({.threads = -1}, std::tuple{reads<VisitedPoint>("position")}, invalid, "-1 threads",
          store);
  Store based = visited_in_memory(BaseMesh::build(octahedron()), 2);
  add_base_positions(based);
  refused({.level = 1}, std::tuple{reads<VisitedPoint>("position")}, invalid,
          "level 1, expected 2 or more", based);
  store.commit();
  store.close();
  Store reading = Store::open(path, {}, default_backends());
  refused({}, std::tuple{updates<VisitedPoint>("position")}, ErrorCode::kBadState,
          "opened for reading", reading);
  CHECK_NOTHROW(
      visit_vertices(reading, {}, std::tuple{rings_of<VisitedPoint>("position")}, nothing));
}

TEST_CASE("VisitVertices_WithoutRings_TellsWhereEachVertexIs") {
  for (const IndexedMesh& mesh : {random_sheet(7, 60), random_sphere(3, 60)}) {
    const BaseMesh base = BaseMesh::build(mesh);
    Store store = visited_in_memory(base, 0);
    store.add_attribute(schema_of<Id>("id"), 3);
    const VertexNumbering numbering(base.topology(), 3);
    int wrong = 0;
    visit_vertices(store, {}, std::tuple{overwrites<Id>("id")},
                   [&](const VertexRun& run, std::span<Id> ids) {
                     for (std::size_t i = 0; i < run.count; ++i) {
                       const PatchPoint at = run.point(i);
                       ids[i] = 0;
                       wrong += numbering.number({at.face, run.level, at.i, at.j}) !=
                                numbering.first_of(run.level) + run.first + i;
                     }
                   });
    CHECK(wrong == 0);
  }
}
