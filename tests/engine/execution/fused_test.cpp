// The fused executor with a user's own rule: every record in its place, every block written once
// and none read, under the budget that it names.
#include <fmt/format.h>

#include "engine/execution/numbering_refiner.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/counting_backend.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

std::vector<AttributeSchema> assorted_schemas() {
  return {{"position", ComponentType::kFloat32, 3}, {"mass", ComponentType::kFloat32, 1},
          {"precise", ComponentType::kFloat64, 3},  {"pair", ComponentType::kUint32, 2},
          {"frame", ComponentType::kFloat32, 6},  // as many bytes as "precise", otherwise divided
          {"five", ComponentType::kUint32, 5}};
}

StoreOptions options_of(const std::string& backend) {
  StoreOptions options = sample_options(backend);
  options.budget_bytes = 64 << 20;
  return options;
}

void check_refined_once(const NumberingCalls& calls, int threads) {
  CHECK(std::ranges::all_of(calls.refined, [](const auto& times) { return times == 1; }));
  CHECK(calls.in_order);
  CHECK(calls.refiners == threads);
}

/// Fills a store in memory and compares every record.
void check_places(const IndexedMesh& mesh, int levels, int threads, std::uint64_t block_bytes,
                  const std::vector<AttributeSchema>& schemas = assorted_schemas()) {
  INFO(fmt::format("{} faces, level {}, {} threads, blocks of {}", mesh.faces.size(), levels,
                   threads, block_bytes));
  StoreOptions options = options_of("memory");
  options.block_bytes = block_bytes;
  const BaseMesh base = BaseMesh::build(mesh);
  Store store = numbered_store({}, base, options, schemas, levels, default_backends());
  NumberingCalls calls(base.face_count());
  fused(store, numbering_pass(store, levels, calls), {threads, {}});
  CHECK(holds_numbers(store, levels));
  check_refined_once(calls, threads);
}

std::uint64_t block_count(const Store& store) {
  std::uint64_t count = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = 1; level <= store.attributes()[id].finest_level; ++level)
      count += StoreAccess::level_file(store, id, level).geometry.block_count();
  return count;
}

/// A mesh of many runs of faces, in an order that keeps few slots under way.
BaseMesh mesh_of_many_runs() {
  return lay_out(BaseMesh::build(random_sheet(5, unless_sanitized(500u, 300u))),
                 LayoutKind::kHilbert)
      .mesh;
}
constexpr int kManyRunsLevels = 6;
const std::vector<AttributeSchema> kManyRunsSchemas = {{"mass", ComponentType::kFloat32, 1}};

}  // namespace

TEST_CASE("Fused_AllSmallMeshes_PutEveryRecordInItsPlace") {
  for (const auto& [name, mesh] : all_meshes()) {
    INFO(name);
    for (const int levels : {1, 3})
      for (const int threads : {1, 2}) check_places(mesh, levels, threads, 4096);
  }
}

TEST_CASE("Fused_LevelsBlocksAndThreads_PutEveryRecordInItsPlace", "[threads]") {
  for (const IndexedMesh& mesh : {random_sphere(1, unless_sanitized(120u, 20u)),
                                  random_sheet(2, unless_sanitized(120u, 20u)), two_components()})
    for (const int levels : {2, 5})
      for (const int threads : {1, 2, 4})
        for (const std::uint64_t block_bytes : {std::uint64_t{4} << 10, std::uint64_t{1} << 20})
          check_places(mesh, levels, threads, block_bytes);
}

TEST_CASE("Fused_RowsOfSlotsLongerThanAPage_PutEveryRecordInItsPlace") {
  check_places(two_triangles(), 9, 1, 4096, {{"precise", ComponentType::kFloat64, 3}});
}

TEST_CASE("Fused_LargestRecords_PutEveryRecordInItsPlace") {
  for (const int levels : {1, 2, 4})
    check_places(two_triangles(), levels, 1, 4096,
                 {{"wide", ComponentType::kFloat64, 255}, {"mass", ComponentType::kFloat32, 1}});
}

TEST_CASE("Fused_HaloOfAnyWidth_ChangesNothing") {
  const BaseMesh base = BaseMesh::build(random_sheet(3, 60));
  for (const std::int64_t halo : {0, 2, 3}) {
    INFO("halo " << halo);
    Store store =
        numbered_store({}, base, options_of("memory"), assorted_schemas(), 3, default_backends());
    NumberingCalls calls(base.face_count());
    fused(store, numbering_pass(store, 3, calls, halo), {2, {}});
    CHECK(holds_numbers(store, 3));
  }
}

TEST_CASE("Fused_RefinedBaseMesh_CountsLevelsFromIt") {
  const BaseMesh base = BaseMesh::build(random_sphere(4, 60));
  Store store =
      numbered_store({}, base, options_of("memory"), assorted_schemas(), 3, default_backends(), 2);
  REQUIRE(store.finest_level() == 5);
  NumberingCalls calls(base.face_count());
  fused(store, numbering_pass(store, 3, calls), {2, {}});
  CHECK(holds_numbers(store, 3));
}

TEST_CASE("Fused_FewerLevelsThanThereAre_LeavesTheOthersAlone") {
  const BaseMesh base = BaseMesh::build(random_sheet(6, 60));
  Store store =
      numbered_store({}, base, options_of("memory"), assorted_schemas(), 4, default_backends());
  NumberingCalls calls(base.face_count());
  fused(store, numbering_pass(store, 3, calls), {1, {}});
  CHECK(holds_numbers(store, 3));
  const std::vector<std::byte> finest = read_level(store, 0, 4);
  CHECK(std::ranges::all_of(finest, [](std::byte byte) { return byte == std::byte{0}; }));
}

// Invariant 5. As many blocks are written as there are, and each holds what it should: none twice.
TEST_CASE("Fused_AnyDurableBackend_WritesEachBlockOnceAndReadsNone", "[threads]") {
  const BaseMesh base = BaseMesh::build(random_sheet(7, unless_sanitized(200u, 40u)));
  for (const std::string& backend : durable_backends())
    for (const int threads : {1, 2, 4}) {
      INFO(backend << " on " << threads << " threads");
      const TemporaryDirectory directory(Medium::kMemory);
      const std::filesystem::path path = directory.path() / "s.plait";
      BackendCounts counts;
      {
        Store store = numbered_store(path, base, options_of(backend), assorted_schemas(), 4,
                                     counting_registry(default_backends(), counts));
        NumberingCalls calls(base.face_count());
        fused(store, numbering_pass(store, 4, calls), {threads, {}});
        check_refined_once(calls, threads);
        store.commit();
        CHECK(counts.read_blocks == 0);
        if (!store.info().backend.in_memory) CHECK(counts.write_blocks == block_count(store));
        store.close();
      }
      Store reopened = Store::open(path, {}, default_backends());
      CHECK(holds_numbers(reopened, 4));
    }
}

TEST_CASE("Fused_BudgetOfWhatItNeeds_StillWritesEachBlockOnceAndReadsNone") {
  const BaseMesh base = mesh_of_many_runs();
  for (const std::string& backend : durable_backends())
    for (const int threads : {1, 2}) {
      INFO(backend << " on " << threads << " threads");
      const TemporaryDirectory directory(Medium::kMemory);
      const std::filesystem::path path = directory.path() / "s.plait";
      BackendCounts counts;
      const auto create = [&](std::uint64_t frame_bytes) {
        StoreOptions options = options_of(backend);
        options.budget_bytes = 128 << 20;
        Store store = numbered_store(path, base, options, kManyRunsSchemas, kManyRunsLevels,
                                     counting_registry(default_backends(), counts));
        leave_for_frames(store, frame_bytes);
        return store;
      };
      NumberingCalls calls(base.face_count());
      std::uint64_t needed = 0;
      {
        const Store store = create(64 << 20);
        const FusedPass pass = numbering_pass(store, kManyRunsLevels, calls);
        needed = fused_needs(store, pass, threads).frames;
        REQUIRE(needed > (64 << 10));
        if (threads == 1) CHECK(needed < block_count(store) * 4096 / 2);
      }
      {
        Store store = create(needed - 1);
        const FusedPass pass = numbering_pass(store, kManyRunsLevels, calls);
        const Error error = error_of([&] { fused(store, pass, {threads, {}}); });
        CHECK(error.code() == ErrorCode::kBudget);
        CHECK(names(error, {"'numbering'", std::to_string(needed), std::to_string(needed - 1)}));
        CHECK(calls.refiners == 0);
        CHECK(store.info().paging.peak_frame_bytes == 0);
        CHECK(counts.write_blocks == 0);
        CHECK(counts.read_blocks == 0);
      }
      Store store = create(needed);
      fused(store, numbering_pass(store, kManyRunsLevels, calls), {threads, {}});
      CHECK(store.info().paging.peak_frame_bytes <= needed);
      store.commit();
      CHECK(counts.read_blocks == 0);
      if (!store.info().backend.in_memory) CHECK(counts.write_blocks == block_count(store));
      check_refined_once(calls, threads);
      CHECK(holds_numbers(store, kManyRunsLevels));
    }
}

// Blocks of 4 KiB, frames of whole pages; five edges, one of them inside.
TEST_CASE("FusedNeeds_TwoTriangles_AreTheBlocksOfAllLevels") {
  const BaseMesh base = BaseMesh::build(two_triangles());
  const auto pages = [&](const AttributeSchema& schema, int levels) {
    const Store store =
        numbered_store({}, base, options_of("memory"), {schema}, levels, default_backends());
    NumberingCalls calls(base.face_count());
    const std::uint64_t bytes = fused_needs(store, numbering_pass(store, levels, calls), 1).frames;
    CHECK(bytes % 4096 == 0);
    return bytes / 4096;
  };
  const AttributeSchema four_bytes{"mass", ComponentType::kFloat32, 1},
      eight_bytes{"pair", ComponentType::kUint32, 2};
  CHECK(pages(four_bytes, 1) == 1);
  // Levels 1 to 4 fit into a block each. At level 5 a slot is of 16 x 16 x 4 bytes: four in a
  // block.
  CHECK(pages(four_bytes, 5) == 4 + 2);
  CHECK(pages(four_bytes, 6) == 4 + 2 + 5);
  CHECK(pages(eight_bytes, 5) == 4 + 3);
  CHECK(pages(eight_bytes, 6) == 4 + 3 + 5 * 2);
}

// At level 7 threads take runs of 16 faces, and two runs for each of them are under way at once.
// Four tetrahedra are a run and have 24 edges in a row, whose slots at levels 7 and 6 are blocks of
// their own, of 64 x 64 and 32 x 32 records: four pages and one.
TEST_CASE("FusedNeeds_ManyRuns_AreTheBlocksOfTheWidestWindow") {
  const BaseMesh base = BaseMesh::build(side_by_side(std::vector(40, tetrahedron())));
  const auto pages = [&](int threads) {
    const Store store =
        numbered_store({}, base, options_of("memory"), kManyRunsSchemas, 7, default_backends());
    NumberingCalls calls(base.face_count());
    const std::uint64_t bytes = fused_needs(store, numbering_pass(store, 7, calls), threads).frames;
    CHECK(bytes % 4096 == 0);
    return bytes / 4096;
  };
  // Levels 7, 6, 5 (4 slots a block), 4 (16), 3 (64), 2 and 1 (one block) at edges 24 to 71.
  CHECK(pages(1) == 48 * 4 + 48 + 12 + 4 + 2 + 1 + 1);
  // The same at edges 120 to 215.
  CHECK(pages(2) == 96 * 4 + 96 + 24 + 7 + 3 + 1 + 1);
}

TEST_CASE("FusedNeeds_MoreThreadsLevelsOrAttributes_NeedsMore") {
  const BaseMesh base = mesh_of_many_runs();
  const auto needs = [&](std::size_t attributes, int levels, int threads) {
    std::vector<AttributeSchema> schemas = assorted_schemas();
    schemas.resize(attributes);
    const Store store =
        numbered_store({}, base, options_of("memory"), schemas, levels, default_backends());
    NumberingCalls calls(base.face_count());
    return fused_needs(store, numbering_pass(store, levels, calls), threads);
  };
  const Needs least = needs(1, 6, 1);
  for (const Needs& more : {needs(1, 6, 2), needs(1, 7, 1), needs(2, 6, 1)}) {
    CHECK(more.frames > least.frames);
    CHECK(more.resident > least.resident);
  }
}
