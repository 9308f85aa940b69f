// One digest, whatever holds the store and whoever walks it.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "kernels/run_variant.h"
#include "plait/error.h"
#include "plait/extend/in_core_mesh.h"
#include "plait/extend/pager.h"
#include "plait/extend/rule_patches.h"
#include "plait/extend/store_access.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr auto kEdits = unless_sanitized<std::uint32_t>(700, 200);
constexpr auto kLargestBlock = unless_sanitized<std::uint64_t>(1 << 20, 64 << 10);

/// The digest in the smallest budget, of the powers of two, that the run accepts.
std::string digest_in_smallest_budget(const BaseMesh& base, const SubdivideOptions& what,
                                      Variant variant) {
  for (variant.budget_bytes = 64 << 10; variant.budget_bytes < (1 << 30);
       variant.budget_bytes *= 2) {
    try {
      return run(base, what, variant).digest;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBudget) throw;
    }
  }
  throw Error(ErrorCode::kBudget, "no budget does");
}

void check_all_variants(const BaseMesh& base, const SubdivideOptions& what) {
  const std::string expected = run(base, what, {}).digest;
  for (const std::string& backend : usable_backends())
    for (const ExecutorKind executor :
         {ExecutorKind::kSweep, ExecutorKind::kTransparent, ExecutorKind::kFused})
      for (int threads = unless_sanitized(1, 2); threads <= 2; ++threads)
        for (std::uint64_t block_bytes = 64 << 10; block_bytes <= kLargestBlock;
             block_bytes *= 16) {
          Variant variant;
          variant.backend = backend;
          variant.executor = executor;
          variant.threads = threads;
          variant.block_bytes = block_bytes;
          variant.layout = block_bytes > (64 << 10) ? LayoutKind::kSpatial : LayoutKind::kHilbert;
          INFO(fmt::format("{} {} threads {} block {}", backend, to_string(executor), threads,
                           block_bytes));
          CHECK(run(base, what, variant).digest == expected);
          variant.layout = LayoutKind::kRcm;
          CHECK(digest_in_smallest_budget(base, what, variant) == expected);
        }
}

}  // namespace

TEST_CASE("Digest_EveryVariantOfAClosedMesh_IsTheSame") {
  check_all_variants(BaseMesh::build(random_sphere(11, kEdits)), {.levels = 4, .normals = true});
}

TEST_CASE("Digest_EveryVariantOfAMeshWithBorders_IsTheSame", "[threads]") {
  check_all_variants(BaseMesh::build(random_sheet(12, kEdits)),
                     {.levels = 3, .normals = true, .limit = true});
}

TEST_CASE("Digest_ButterflyAndMidpointByAnyExecutor_IsTheSame") {
  for (const Scheme scheme : {Scheme::kButterfly, Scheme::kMidpoint}) {
    const SubdivideOptions what{.scheme = scheme, .levels = 3};
    for (const IndexedMesh& mesh : {random_sphere(21, 300), random_sheet(22, 300)}) {
      const BaseMesh base = BaseMesh::build(mesh);
      Variant variant;
      const std::string expected = run(base, what, variant).digest;
      variant.executor = ExecutorKind::kTransparent;
      CHECK(run(base, what, variant).digest == expected);
      variant.threads = 2;
      variant.layout = LayoutKind::kHilbert;
      variant.executor = ExecutorKind::kSweep;
      CHECK(run(base, what, variant).digest == expected);
      variant.executor = ExecutorKind::kFused;
      CHECK(run(base, what, variant).digest == expected);
    }
  }
}

TEST_CASE("Digest_AnotherMesh_IsAnother") {
  const SubdivideOptions what{.levels = 2};
  CHECK(run(BaseMesh::build(random_sphere(1, 50)), what, {}).digest !=
        run(BaseMesh::build(random_sphere(2, 50)), what, {}).digest);
}

TEST_CASE("LoopPatches_OverArraysAndOverAStore_GiveTheSameBits") {
  for (const IndexedMesh& mesh : {random_sphere(31, 200), random_sheet(32, 200)}) {
    const BaseMesh base = BaseMesh::build(mesh);
    constexpr int kLevels = 4;
    InCoreMesh<Vector3<float>> arrays(base, kLevels);
    for (std::size_t v = 0; v < base.vertex_count(); ++v)
      arrays.base_records()[v] = narrow<float>(base.positions()[v]);
    for (int level = 1; level <= kLevels; ++level)
      refine_patches(arrays, level, loop_scheme().rule<float>());

    Store store =
        Store::create({}, base, {.backend = "memory", .block_bytes = 4096}, default_backends());
    add_base_positions(store);
    subdivide(store, {.levels = kLevels});
    StorePatches<Vector3<float>> patches(store, store.attribute("position"), 1 << 20);
    patches.activate(kLevels, 1, 0);
    bool equal = true;
    for (FaceId face = 0; face < base.face_count(); ++face) {
      const auto expected = arrays.patch(face);
      const auto found = patches.patch(face);
      for (int j = 0; j <= 1 << kLevels; ++j)
        for (int i = 0; i + j <= 1 << kLevels; ++i)
          equal &= expected.at(kLevels, i, j) == found.at(kLevels, i, j);
    }
    CHECK(equal);
  }
}

TEST_CASE("Sweep_WriteOnlyLevels_ReadNothingAndWriteOnce") {
  const BaseMesh base = BaseMesh::build(random_sphere(41, 400));
  Variant variant;
  variant.backend = "pread";
  variant.block_bytes = 4096;
  const PagingStatistics statistics = run(base, {.levels = 1}, variant).statistics;
  CHECK(statistics.blocks_read == 0);
  CHECK(statistics.bytes_written == base.edge_count() * 12);
}

TEST_CASE("ExecutorKind_Auto_IsFusedInANewStoreAndTheSweepWhereLevelsMatter") {
  const BaseMesh base = BaseMesh::build(random_sphere(5, 60));
  const auto made = [&](SubdivideOptions what, int first_levels) {
    Store store = Store::create({}, base, {}, default_backends());
    add_base_positions(store);
    if (first_levels > 0) subdivide(store, {.levels = first_levels});
    const ExecutorKind executor = plan_subdivision(store, what).options().executor;
    subdivide(store, what);
    return std::pair(executor, digest(store).to_string());
  };
  SubdivideOptions what{.levels = 3};
  const auto [executor, expected] = made(what, 0);
  CHECK(executor == ExecutorKind::kFused);
  CHECK(made(what, 1) == std::pair(ExecutorKind::kSweep, expected));
  int levels = 0;
  what.level_done = [&](int) { ++levels; };
  CHECK(made(what, 0) == std::pair(ExecutorKind::kSweep, expected));
  CHECK(levels == 3);
  what.executor = ExecutorKind::kTransparent;
  CHECK(made(what, 0) == std::pair(ExecutorKind::kTransparent, expected));
  // The fused executor has blocks of all levels open, and says so when the budget is too small.
  what = {.levels = 5};
  for (const std::uint64_t budget : {std::uint64_t{64} << 10, std::uint64_t{64} << 20}) {
    Store store =
        Store::create({}, base, {.block_bytes = 4096, .budget_bytes = budget}, default_backends());
    add_base_positions(store);
    CHECK(plan_subdivision(store, what).options().executor ==
          (budget < 1 << 20 ? ExecutorKind::kSweep : ExecutorKind::kFused));
  }
  CHECK(executor_from_name("auto") == ExecutorKind::kAuto);
  CHECK_THROWS_WITH(executor_from_name("x"),
                    "unknown executor 'x', expected auto, fused, sweep, transparent");
}

TEST_CASE("Subdivision_OfMoreThreadsThanTheBudgetHolds_TakesFewerWithTheSameBits", "[threads]") {
  const BaseMesh base = BaseMesh::build(random_sphere(6, 60));
  std::string expected;
  for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep})
    for (const std::uint64_t budget : {std::uint64_t{4} << 20, std::uint64_t{1} << 30}) {
      CAPTURE(to_string(executor), budget);
      const TemporaryDirectory directory(Medium::kMemory);
      Store store = Store::create(directory.path() / "s.plait", base,
                                  {.backend = "pread", .block_bytes = 4096, .budget_bytes = budget},
                                  default_backends());
      add_base_positions(store);
      SubdivideOptions what{.executor = executor, .levels = 6};
      PlannedSubdivision one = plan_subdivision(store, what);
      what.threads = 256;
      PlannedSubdivision planned = plan_subdivision(store, what);
      const int threads = planned.options().threads;
      if (budget < 1 << 30) {
        CHECK(threads > 1);
        CHECK(threads < 256);
      } else {
        CHECK(threads == 256);
      }
      CHECK(planned.needs().resident == one.needs().resident);
      planned.run();
      CHECK(StoreAccess::pager(store).budget_bytes() == budget);
      const std::string found = digest(store).to_string();
      if (expected.empty()) expected = found;
      CHECK(found == expected);
    }
}
