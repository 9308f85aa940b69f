// Blocks that a scheme makes again are stored in no bytes, and read with the same bits.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cfenv>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "kernels/tension_rule.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/file.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/own_rule.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

namespace fs = std::filesystem;
using Point = Vector3<float>;

StoreOptions compressed(std::uint64_t block_bytes = 4096,
                        const char* pipeline = "predicted,zstd:1") {
  return {.backend = "compressed",
          .pipeline = pipeline,
          .durability = Durability::kNone,
          .block_bytes = block_bytes,
          .budget_bytes = 64 << 20};
}

BackendRegistry registry_with(std::shared_ptr<const BlockMakers> makers) {
  PipelineRegistry pipelines = default_pipelines();
  pipelines.set_block_makers(std::move(makers));
  return default_backends(pipelines);
}

Store refined(const fs::path& path, const BaseMesh& base, const StoreOptions& options,
              const SubdivideOptions& how, bool double_precision = false,
              const BackendRegistry& backends = default_backends()) {
  Store store = Store::create(path, base, options, backends);
  add_base_positions(store, double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
  subdivide(store, how);
  store.commit();
  return store;
}

/// What the sweep makes in memory.
std::string expected_digest(const BaseMesh& base, SubdivideOptions how,
                            bool double_precision = false) {
  how.executor = ExecutorKind::kSweep;
  how.threads = 1;
  Store store = refined({}, base, {.backend = "memory"}, how, double_precision);
  return digest(store).to_string();
}

std::uint64_t blocks_with(const Store& store, BlockEncoding encoding) {
  std::uint64_t count = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      for (const BlockEntry& entry : StoreAccess::level_file(store, id, level).table.entries())
        count += entry.encoding == encoding ? 1u : 0u;
  return count;
}

std::uint64_t all_blocks(const Store& store) {
  std::uint64_t count = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      count += StoreAccess::level_file(store, id, level).table.size();
  return count;
}

SubdivideOptions fused_to(int levels, bool normals = true) {
  return {.executor = ExecutorKind::kFused, .levels = levels, .normals = normals, .threads = 2};
}

void change_block(Store& store, AttributeId attribute, int level, std::uint64_t block) {
  const PinnedBlock pinned = StoreAccess::open_session(store).pin(
      StoreAccess::level_file(store, attribute, level), block, Access::kUpdate);
  pinned.bytes()[5] ^= std::byte{1};
}

/// Makes other bytes than the library's makers, as a program with other arithmetic would.
class OtherMakers final : public BlockMakers {
 public:
  std::string recipe(const PlannedLevels&) const override { return {}; }
  std::unique_ptr<BlockMaker> open(const MadeLevel& level) const override {
    class Other final : public BlockMaker {
     public:
      explicit Other(std::unique_ptr<BlockMaker> right) : right_(std::move(right)) {}
      std::uint64_t scratch_bytes() const noexcept override { return right_->scratch_bytes(); }
      void make(std::uint64_t block, SourceBytes sources, std::span<std::byte> raw) const override {
        right_->make(block, sources, raw);
        raw.back() ^= std::byte{1};
      }
      bool makes(std::uint64_t, SourceBytes, std::span<const std::byte>) const override {
        return false;
      }

     private:
      std::unique_ptr<BlockMaker> right_;
    };
    return std::make_unique<Other>(library_block_makers()->open(level));
  }
};

}  // namespace

TEST_CASE("Predicted_EveryBlockOfAScheme_TakesNoByteAndHasTheBitsOfTheSweep") {
  const OneRingScheme tension = own_scheme("tension", OwnTensionRule{});
  const BackendRegistry with_own = registry_with(subdivision_block_makers({tension}));
  const bool double_precision = GENERATE(false, true);
  const std::uint64_t block_bytes = GENERATE(4096u, 1u << 20);
  const BaseMesh meshes[] = {BaseMesh::build(random_sheet(11, 120)),
                             BaseMesh::build(torus_grid(9, 7)), BaseMesh::build(tetrahedron())};
  for (const BaseMesh& base : meshes)
    for (const int which : {0, 1, 2, 3}) {
      SubdivideOptions how = fused_to(4);
      if (which == 1) how.limit = true;
      if (which == 2) how.scheme = Scheme::kMidpoint;
      if (which == 3) how.scheme = tension;
      CAPTURE(double_precision, block_bytes, base.face_count(), which);
      const TemporaryDirectory directory(Medium::kMemory);
      const fs::path path = directory.path() / "s.plait";
      {
        const Store store =
            refined(path, base, compressed(block_bytes), how, double_precision, with_own);
        CHECK(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store));
      }
      for (int level = 1; level <= 4; ++level) {
        CHECK(fs::file_size(path / ("attribute0.level0" + std::to_string(level) + ".1")) == 0);
        CHECK(fs::file_size(path / ("attribute1.level0" + std::to_string(level) + ".1")) == 0);
      }
      Store again = Store::open(path, {}, with_own);
      CHECK(digest(again).to_string() == expected_digest(base, how, double_precision));
      CHECK(verify(again).damaged_count == 0);
    }
}

TEST_CASE("Predicted_BlocksOfAMebibyte_CostAtMostAHundredthOfABitAVertex") {
  const TemporaryDirectory directory(Medium::kMemory);
  const Store store = refined(directory.path() / "s.plait", BaseMesh::build(torus_grid(16, 16)),
                              compressed(1 << 20), fused_to(6));
  std::uint64_t bytes = 0, records = 0;
  for (AttributeId id = 0; id < 2; ++id)
    for (int level = 1; level <= 6; ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      bytes += file.backend->stored_bytes() + file.table.size() * sizeof(BlockEntry);
      records += file.geometry.total_bytes() / file.geometry.record_bytes();
    }
  CHECK(static_cast<double>(8 * bytes) <= 0.01 * static_cast<double>(records));
}

TEST_CASE("Predicted_BlockWithAnotherBit_IsStored") {
  const TemporaryDirectory directory(Medium::kMemory);
  const BaseMesh base = BaseMesh::build(random_sheet(3, 100));
  const int level = GENERATE(1, 3);
  const auto attribute = static_cast<AttributeId>(GENERATE(0, 1));
  Store store = refined(directory.path() / "s.plait", base, compressed(), fused_to(3));
  const std::uint64_t last = StoreAccess::level_file(store, attribute, level).table.size() - 1;
  const std::string before = digest(store).to_string();
  change_block(store, attribute, level, last);
  store.commit();
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store) - 1);
  const std::string changed = digest(store).to_string();
  CHECK(changed != before);
  store.close();
  Store again = Store::open(directory.path() / "s.plait", {.writable = true}, default_backends());
  CHECK(digest(again).to_string() == changed);
  // Written as it was, the block takes no byte again.
  change_block(again, attribute, level, last);
  again.commit();
  CHECK(blocks_with(again, BlockEncoding::kPredicted) == all_blocks(again));
  CHECK(digest(again).to_string() == before);
}

TEST_CASE("Predicted_BlockThatIsPredictedAgain_GivesItsPlaceInTheFileBack") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = refined(directory.path() / "s.plait", BaseMesh::build(random_sheet(3, 100)),
                        compressed(), fused_to(3, false));
  const auto bytes = [&] {
    return fs::file_size(StoreAccess::level_file(std::as_const(store), 0, 3).path);
  };
  std::uint64_t after_some = 0;
  for (int round = 0; round < 30; ++round) {
    change_block(store, 0, 3, 1);
    store.commit();
    if (round == 7) after_some = bytes();
  }
  CHECK(after_some > 0);
  CHECK(bytes() <= after_some);
}

TEST_CASE("Predicted_ZerosOfTheOtherSign_AreStored") {
  IndexedMesh flat = sheet(6, 5);
  for (auto& point : flat.positions) point.z = 0;
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  constexpr std::size_t kSignOfZ = 3 * sizeof(float) - 1;
  {
    Store store = refined(path, BaseMesh::build(flat), compressed(), fused_to(2, false));
    REQUIRE(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store));
    {
      const PinnedBlock pinned = StoreAccess::open_session(store).pin(
          StoreAccess::level_file(store, 0, 2), 0, Access::kUpdate);
      pinned.bytes()[kSignOfZ] ^= std::byte{0x80};
    }
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store) - 1);
  const PinnedBlock pinned =
      StoreAccess::open_session(store).pin(StoreAccess::level_file(std::as_const(store), 0, 2), 0);
  CHECK(pinned.bytes()[kSignOfZ] == std::byte{0x80});
}

TEST_CASE("Predicted_DenormalPositions_HaveTheBitsOfTheSweep") {
  IndexedMesh tiny = torus_grid(6, 5);
  for (auto& point : tiny.positions) point = 1e-41 * point;
  const BaseMesh base = BaseMesh::build(tiny);
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = refined(directory.path() / "s.plait", base, compressed(), fused_to(3));
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store));
  CHECK(digest(store).to_string() == expected_digest(base, fused_to(3)));
}

TEST_CASE("Predicted_AnyOrderOfChanges_ReadsWhatWasWritten") {
  // Base records, blocks of coarse and of fine levels, and finer levels: none of them is what a
  // predicted block is made from.
  const BaseMesh base = BaseMesh::build(random_sheet(5, 80));
  std::vector<int> order = {0, 1, 2, 3};
  do {
    const TemporaryDirectory directory(Medium::kMemory);
    Store store = refined(directory.path() / "s.plait", base, compressed(), fused_to(2, false));
    Store twin = refined({}, base, {.backend = "memory"}, fused_to(2, false));
    for (const int change : order) {
      for (Store* const to : {&store, &twin}) {
        if (change == 0) to->base_records<Point>(0)[1].x += 1;
        if (change == 1) change_block(*to, 0, 1, 0);
        if (change == 2) change_block(*to, 0, 2, 0);
        if (change == 3) {
          subdivide(*to, {.levels = to->finest_level() + 1});
        }
      }
      if (change % 2 == 0) store.commit();
      CHECK(digest(store).to_string() == digest(twin).to_string());
    }
    store.commit();
    store.close();
    Store again = Store::open(directory.path() / "s.plait", {}, default_backends());
    CHECK(digest(again).to_string() == digest(twin).to_string());
  } while (std::ranges::next_permutation(order).found);
}

TEST_CASE("Predicted_FinerLevelsOfTheScheme_LeaveNoStalePrediction") {
  // Loop's coarse vertices move with a finer level.
  const BaseMesh base = BaseMesh::build(torus_grid(6, 5));
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = refined(directory.path() / "s.plait", base, compressed(), fused_to(2, false));
  subdivide(store, {.levels = 3});
  store.commit();
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == 0);
  CHECK(digest(store).to_string() == expected_digest(base, fused_to(3, false)));
  // Encoded anew, the levels are what the scheme makes.
  recode_attribute(store, 0, "predicted+hierarchy+shuffle,zstd:1");
  store.commit();
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == all_blocks(store));
  CHECK(digest(store).to_string() == expected_digest(base, fused_to(3, false)));
}

TEST_CASE("Predicted_CopyOfRawLevels_IsPredictedAndBack") {
  const BaseMesh base = BaseMesh::build(torus_grid(8, 6));
  const TemporaryDirectory directory(Medium::kMemory);
  SubdivideOptions how = fused_to(3);
  how.limit = true;
  Store raw = refined(directory.path() / "raw.plait", base, {.durability = Durability::kNone}, how);
  Store made = Store::create(directory.path() / "made.plait", raw.base(),
                             compressed(4096, "predicted+shuffle,lz4"), default_backends());
  copy_levels(raw, made);
  made.commit();
  CHECK(blocks_with(made, BlockEncoding::kPredicted) == all_blocks(made));
  Store back = Store::create(directory.path() / "back.plait", raw.base(),
                             {.durability = Durability::kNone}, default_backends());
  copy_levels(made, back);
  CHECK(digest(back).to_string() == digest(raw).to_string());
}

TEST_CASE("Predicted_SchemeThatNobodyKnows_IsANamedErrorOfItsBlocksAlone") {
  const OneRingScheme tension = own_scheme("tension", OwnTensionRule{});
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  SubdivideOptions how = fused_to(2);
  how.scheme = tension;
  {
    Store store = refined(path, BaseMesh::build(torus_grid(6, 5)), compressed(), how, false,
                          registry_with(subdivision_block_makers({tension})));
    change_block(store, 0, 2, 0);
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  CHECK(std::as_const(store).base_records<Point>(0).size() == 30);
  Session session = StoreAccess::open_session(store);
  const Store& reading = store;
  CHECK_NOTHROW(session.pin(StoreAccess::level_file(reading, 0, 2), 0));
  const Error error = error_of([&] { session.pin(StoreAccess::level_file(reading, 0, 1), 0); });
  CHECK(error.code() == ErrorCode::kNotSupported);
  CHECK_THAT(error.what(), Catch::Contains("scheme 'tension'"));
}

TEST_CASE("Predicted_OtherArithmetic_IsFoundAndNeverReturned") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  { refined(path, BaseMesh::build(torus_grid(6, 5)), compressed(), fused_to(2)); }
  const BackendRegistry other = registry_with(std::make_shared<OtherMakers>());
  Store store = Store::open(path, {}, other);
  const Error error = error_of([&] {
    StoreAccess::open_session(store).pin(StoreAccess::level_file(std::as_const(store), 1, 2), 0);
  });
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK_THAT(error.what(), Catch::Contains("made again, it has checksum"));
  CHECK(verify(store).damaged_count == all_blocks(store));
}

TEST_CASE("Predicted_ProgramThatRoundsUpwards_ReadsTheSameBytes") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const BaseMesh base = BaseMesh::build(torus_grid(6, 5));
  { refined(path, base, compressed(), fused_to(3)); }
  Store store = Store::open(path, {.io_threads = 0}, default_backends());
  std::fesetround(FE_UPWARD);
  const std::uint64_t damaged = verify(store).damaged_count;
  std::fesetround(FE_TONEAREST);
  CHECK(damaged == 0);
}

TEST_CASE("Predicted_RequiredFeature_StandsInTheManifestWhileABlockIsPredicted") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const auto flags = [&](std::uint64_t version) {
    std::uint32_t required = 0;
    File(path / "manifest", OpenMode::kRead)
        .read_at(version % 2 * 4096 + 12, std::as_writable_bytes(std::span(&required, 1)));
    return required;
  };
  Store store = refined(path, BaseMesh::build(torus_grid(6, 5)), compressed(), fused_to(2));
  CHECK(flags(1) == 1);
  for (AttributeId id = 0; id < 2; ++id) recode_attribute(store, id, "zstd:1");
  store.commit();
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == 0);
  CHECK(flags(2) == 0);
}

TEST_CASE("Predicted_LevelFileThatIsLost_IsMadeAgain") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const BaseMesh base = BaseMesh::build(torus_grid(6, 5));
  { refined(path, base, compressed(), fused_to(2)); }
  fs::remove(path / "attribute0.level02.1");
  const RepairReport report = repair(path, {}, default_backends());
  CHECK(report.whole());
  CHECK(report.rebuilt_files.size() == 1);
  Store store = Store::open(path, {}, default_backends());
  CHECK(digest(store).to_string() == expected_digest(base, fused_to(2)));
}

TEST_CASE("Predicted_MeshWithAHub_IsStored") {
  const BaseMesh base = BaseMesh::build(closed_fan(256));
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = refined(directory.path() / "s.plait", base, compressed(), fused_to(2));
  CHECK(blocks_with(store, BlockEncoding::kPredicted) == 0);
  CHECK(digest(store).to_string() == expected_digest(base, fused_to(2)));
}

TEST_CASE("Predicted_TextThatIsNoRecipe_IsRefused") {
  const BaseMesh base = BaseMesh::build(torus_grid(4, 3));
  const LevelGeometry geometry = base.geometry(BaseRelativeLevel(1), 12, 4096);
  const LevelSurroundings surroundings{base.topology(), 0, {}, base.positions()};
  for (const char* const recipe :
       {"", "loop", "loop/position/float32", "loop/position/float32/0", "loop/position/float32/99",
        "loop/position/float32/1x", "loop/other/float32/1", "loop/position/int8/1",
        "/position/float32/1", "loop/position/float32/1/2"}) {
    CAPTURE(recipe);
    CHECK(error_of([&] {
            library_block_makers()->open(
                {recipe, schema_of<Point>("position"), 0, geometry, surroundings});
          }).code() == ErrorCode::kInvalidArgument);
  }
}
