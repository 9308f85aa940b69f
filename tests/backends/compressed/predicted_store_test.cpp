// Stores whose levels are predicted from coarser ones: no order of writes leaves a block that
// decodes to other records than those that were written.
#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Point = Vector3<float>;
constexpr const char* kPredicted = "hierarchy+shuffle,zstd:1";
constexpr int kFinest = 4;

StoreOptions options_with(const char* pipeline) {
  return {.backend = "compressed",
          .pipeline = pipeline,
          .durability = Durability::kNone,
          .block_bytes = 4096,
          .budget_bytes = 1 << 20};
}

/// A store of positions, with the pipeline and no level yet.
struct PredictedSurface {
  explicit PredictedSurface(const char* pipeline = kPredicted)
      : path(directory.path() / "s.plait"),
        store(Store::create(path, BaseMesh::build(torus_grid(12, 8)), options_with(pipeline),
                            default_backends())) {
    position = store.add_attribute(schema_of<Point>("position"));
    float next = 0;
    for (Point& point : store.base_records<Point>(position)) point = {next, -next, next += 0.25f};
  }
  void write_level(int level, float offset = 0) {
    Session session = StoreAccess::open_session(store);
    LevelFile& file = StoreAccess::level_file(store, position, level);
    for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
      const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
      auto* const numbers = reinterpret_cast<float*>(pinned.bytes().data());
      for (std::size_t i = 0; i < pinned.bytes().size() / sizeof(float); ++i)
        numbers[i] = offset + static_cast<float>(i % 97) + static_cast<float>(block);
    }
  }
  void write_all() {
    for (int level = 1; level <= kFinest; ++level) {
      StoreAccess::add_final_level(store, position);
      write_level(level);
    }
  }
  Store reopened(bool writable) {
    const OpenOptions open{.writable = writable, .durability = Durability::kNone};
    return Store::open(path, open, default_backends());
  }

  TemporaryDirectory directory;
  std::filesystem::path path;
  Store store;
  AttributeId position = 0;
};

}  // namespace

TEST_CASE("PredictedStore_LevelsAndBaseRecordsThatOthersNeed_CannotBeChanged") {
  PredictedSurface surface;
  surface.write_all();
  const auto check = [](Store& store) {
    const AttributeId position = store.attribute("position");
    for (int level = 1; level < kFinest; ++level)
      for (const Access access : {Access::kOverwrite, Access::kUpdate})
        CHECK(code_of([&] {
                StoreAccess::open_session(store).pin(
                    StoreAccess::level_file(store, position, level), 0, access);
              }) == ErrorCode::kBadState);
    CHECK(code_of([&] { store.base_records<Point>(position); }) == ErrorCode::kBadState);
    CHECK_NOTHROW(std::as_const(store).base_records<Point>(position));
    CHECK_NOTHROW(StoreAccess::open_session(store).pin(
        StoreAccess::level_file(store, position, kFinest), 0, Access::kUpdate));
  };
  check(surface.store);
  surface.store.commit();
  check(surface.store);
  const std::string expected = digest(surface.store).to_string();
  surface.store.close();
  Store again = surface.reopened(true);
  CHECK(digest(again).to_string() == expected);
  check(again);
  CHECK(verify(again).damaged_count == 0);
}

TEST_CASE("PredictedStore_Digest_DecodesEachBlockOnce_AndIsTheSumOfTheLevelsUnderAnyBudget") {
  PredictedSurface surface;
  surface.write_all();
  surface.store.commit();
  unsigned __int128 expected = 0;
  for (int level = 0; level <= kFinest; ++level) {
    const Digest one = digest(surface.store, {.level = level});
    expected += (static_cast<unsigned __int128>(one.high) << 64) + one.low;
  }
  surface.store.close();
  int fitted = 0, refused = 0;
  for (std::uint64_t budget = 1 << 20; budget >= 1 << 16; budget = budget * 3 / 4) {
    CAPTURE(budget);
    const OpenOptions open{.budget_bytes = budget};
    Store store = Store::open(surface.path, open, default_backends());
    try {
      const Digest found = digest(store, {.threads = 2});
      CHECK(((static_cast<unsigned __int128>(found.high) << 64) + found.low == expected));
      if (fitted++ > 0) continue;
      std::uint64_t blocks = 0;
      for (int level = 1; level <= kFinest; ++level)
        blocks += StoreAccess::level_file(store, 0, level).geometry.block_count();
      CHECK(store.info().paging.blocks_read == blocks);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBudget);
      ++refused;
    }
  }
  CHECK(fitted > 3);
  CHECK(refused > 0);
}

TEST_CASE("PredictedStore_FinerLevelBeforeTheCoarserOneIsComplete_IsRefused") {
  PredictedSurface surface;
  StoreAccess::add_final_level(surface.store, surface.position);
  StoreAccess::add_final_level(surface.store, surface.position);
  LevelFile& coarse = StoreAccess::level_file(surface.store, surface.position, 1);
  {
    Session session = StoreAccess::open_session(surface.store);
    const PinnedBlock held = session.pin(coarse, 0, Access::kOverwrite);
    CHECK(code_of([&] { surface.write_level(2); }) == ErrorCode::kBadState);
  }
  surface.write_level(1);
  surface.write_level(2);
  CHECK(code_of([&] { surface.write_level(1); }) == ErrorCode::kBadState);
}

TEST_CASE("PredictedStore_ContextThatChangedAllTheSame_IsFoundWhenABlockIsRead") {
  const bool changes_base = GENERATE(false, true);
  PredictedSurface surface;
  const std::span<Point> base = surface.store.base_records<Point>(surface.position);
  surface.write_all();
  surface.store.commit();  // nothing is on its way when the context changes
  if (changes_base) {
    base[0].x += 1;  // by way of a span from before
  } else {
    StoreAccess::level_file(surface.store, surface.position, 2).is_fixed = false;
    surface.write_level(2, 0.5f);
  }
  surface.store.commit();
  surface.store.close();
  Store again = surface.reopened(false);
  const VerifyReport report = verify(again);
  CHECK(report.damaged_count > 0);
  for (const DamagedBlock& block : report.damaged) {
    CHECK(block.level >= (changes_base ? 1 : 3));
    CHECK(block.reason.find("have changed") != std::string::npos);
  }
  CHECK(code_of([&] { digest(again); }) == ErrorCode::kCorruption);
}

TEST_CASE("PredictedStore_EncodedAnewWithoutPrediction_CanBeChangedAgain") {
  PredictedSurface surface;
  surface.write_all();
  surface.store.commit();
  const std::string expected = digest(surface.store).to_string();
  recode_attribute(surface.store, surface.position, "shuffle,lz4");
  CHECK(surface.store.attributes().size() == 1);
  CHECK(surface.store.attributes()[0].schema.name == "position");
  surface.store.commit();
  CHECK(digest(surface.store).to_string() == expected);
  surface.write_level(1, 3);
  surface.store.base_records<Point>(surface.position)[0].x = 7;
  surface.store.commit();
  CHECK(digest(surface.store).to_string() != expected);
  surface.store.close();
  Store again = surface.reopened(false);
  CHECK(verify(again).damaged_count == 0);
}

TEST_CASE("PredictedStore_EncodedAnewWithPrediction_DoesNotNeedTheOldLevels") {
  PredictedSurface surface("shuffle,lz4");
  surface.write_all();
  const std::string expected = digest(surface.store).to_string();
  recode_attribute(surface.store, surface.position, kPredicted);
  CHECK(StoreAccess::level_file(surface.store, surface.position, 3).pipeline == kPredicted);
  surface.store.commit();
  CHECK(digest(surface.store).to_string() == expected);
  StoreAccess::open_session(surface.store)
      .pin(StoreAccess::level_file(surface.store, surface.position, kFinest), 0, Access::kUpdate);
  surface.store.commit();
  surface.store.close();
  Store again = surface.reopened(true);
  CHECK(digest(again).to_string() == expected);
}

TEST_CASE("PredictedStore_NormalsOfTheLibrarysRule_TakeNextToNothingOnTheFinestLevel") {
  for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep})
    for (const bool precise : {false, true})
      for (const IndexedMesh& mesh :
           {torus_grid(9, 7), random_sheet(4, 60), random_sphere(2, 80)}) {
        const TemporaryDirectory directory;
        StoreOptions options = options_with("shuffle,lz4");
        options.block_bytes = 64 << 10;
        Store store = Store::create(directory.path() / "s.plait", BaseMesh::build(mesh), options,
                                    default_backends());
        add_base_positions(store, precise ? ComponentType::kFloat64 : ComponentType::kFloat32);
        subdivide(store, {.executor = executor, .levels = kFinest, .normals = true});
        store.commit();
        const std::string expected = digest(store).to_string();
        recode_attribute(store, store.attribute("position"), kPredicted);
        recode_attribute(store, store.attribute("normal"), "normals,zstd:1");
        store.commit();
        CHECK(digest(store).to_string() == expected);
        const LevelFile& finest =
            StoreAccess::level_file(store, store.attribute("normal"), kFinest);
        std::uint64_t stored_bytes = 0;
        for (const BlockEntry& entry : finest.table.entries()) stored_bytes += entry.stored_bytes;
        CHECK(stored_bytes < finest.geometry.total_bytes() / 100);
        CHECK(verify(store).damaged_count == 0);
        // The positions cannot go while normals are encoded from them.
        CHECK(code_of([&] { recode_attribute(store, store.attribute("position"), "lz4"); }) ==
              ErrorCode::kBadState);
        CHECK(store.attributes().size() == 2);
      }
}

TEST_CASE("PredictedStore_CancelledWhileItIsEncodedAnew_IsAsBefore") {
  PredictedSurface surface("shuffle,lz4");
  surface.write_all();
  surface.store.commit();
  const std::string expected = digest(surface.store).to_string();
  int calls = 0;
  CHECK(code_of([&] {
          RecodeOptions options;
          options.progress = [&](const Progress&) { return ++calls < 3; };
          recode_attribute(surface.store, surface.position, kPredicted, options);
        }) == ErrorCode::kCancelled);
  CHECK(calls == 3);
  CHECK(surface.store.attributes().size() == 1);
  CHECK(digest(surface.store).to_string() == expected);
  surface.write_level(1, 3);
  CHECK_NOTHROW(surface.store.commit());
}

TEST_CASE("PredictedStore_LevelsOfAnyPass_AreEncodedByTheCommit") {
  const ExecutorKind executor =
      GENERATE(ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent);
  const char* const pipeline =
      GENERATE(false, true) ? kPredicted : "shuffle,lz4;@2=hierarchy+shuffle,zstd:1";
  PredictedSurface plain("shuffle,lz4"), surface(pipeline);
  for (Store* store : {&plain.store, &surface.store}) {
    store->remove_attribute(0);
    add_base_positions(*store);
    subdivide(*store, {.executor = executor, .levels = kFinest});
  }
  const std::string expected = digest(plain.store).to_string();
  Store& store = surface.store;
  CHECK(digest(store).to_string() == expected);
  CHECK(StoreAccess::level_file(store, 0, 2).pipeline != kPredicted);
  const std::span<const Point> base = std::as_const(store).base_records<Point>(0);
  surface.write_level(2, 3);  // nothing is encoded from it yet
  plain.write_level(2, 3);
  const std::string changed = digest(plain.store).to_string();
  CHECK(changed != expected);
  store.commit();
  const LevelPipelines wanted(pipeline);
  for (int level = 1; level <= kFinest; ++level)
    CHECK(StoreAccess::level_file(store, 0, level).pipeline == wanted.of(level));
  CHECK(store.attributes().size() == 1);
  CHECK(std::as_const(store).base_records<Point>(0).data() == base.data());
  CHECK(code_of([&] { surface.write_level(1); }) == ErrorCode::kBadState);
  CHECK(digest(store).to_string() == changed);
  const std::uint64_t sequence = store.sequence();
  store.commit();  // nothing is left to do
  CHECK(store.sequence() == sequence);
  store.close();
  Store again = surface.reopened(true);
  CHECK(verify(again).damaged_count == 0);
  CHECK(digest(again).to_string() == changed);
  // A level that comes later has the attribute's pipeline too.
  again.add_level(0);
  again.commit();
  CHECK(StoreAccess::level_file(again, 0, kFinest + 1).pipeline == wanted.of(kFinest + 1));
}

TEST_CASE("PredictedStore_FinishOfTheEncodingCancelled_GoesOnOrIsRolledBack") {
  const bool goes_on = GENERATE(false, true);
  const int first_call = GENERATE(1, 3, 40);
  PredictedSurface surface;
  Store& store = surface.store;
  store.commit();
  const std::string before = digest(store).to_string();
  const AttributeId other = store.add_attribute(schema_of<Point>("other"), kFinest);
  subdivide(store, {.levels = kFinest});
  const std::string expected = digest(store).to_string();
  int calls = 0;
  std::uint64_t done = 0;
  CHECK(code_of([&] {
          store.finish_encoding([&](const Progress& now) {
            CHECK(now.phase == "encode");
            CHECK(now.done >= done);
            CHECK(now.done <= now.total);
            done = now.done;
            return ++calls < first_call;
          });
        }) == ErrorCode::kCancelled);
  CHECK(calls == first_call);
  CHECK(store.attributes().size() == 2);
  CHECK(digest(store).to_string() == expected);
  if (goes_on) {
    store.finish_encoding();
    CHECK(StoreAccess::level_file(store, other, kFinest).pipeline == kPredicted);
    store.commit();
  } else {
    store.roll_back();
    CHECK(store.attributes().size() == 1);
    CHECK(store.finest_level() == 0);
    CHECK_NOTHROW(store.commit());
  }
  CHECK(digest(store).to_string() == (goes_on ? expected : before));
  store.close();
  Store again = surface.reopened(false);
  CHECK(verify(again).damaged_count == 0);
  CHECK(digest(again).to_string() == (goes_on ? expected : before));
}

TEST_CASE("PredictedStore_CommitInThePauseOfALongerWork_IsRefusedInsteadOfLeavingLevelsAsTheyAre") {
  PredictedSurface surface;
  Store& store = surface.store;
  store.commit();
  SubdivideOptions options{
      .executor = ExecutorKind::kSweep, .levels = 2, .level_done = [&](int) { store.commit(); }};
  CHECK(code_of([&] { subdivide(store, options); }) == ErrorCode::kBadState);
  store.roll_back();
  options.level_done = {};
  subdivide(store, options);
  CHECK_NOTHROW(store.commit());
}

TEST_CASE("PredictedStore_LittleMemory_IsCopiedAndReadByManyThreads", "[threads]") {
  PredictedSurface plain("shuffle,lz4");
  plain.write_all();
  StoreOptions options = options_with(kPredicted);
  options.budget_bytes = 192 << 10;
  options.io_threads = GENERATE(0, 2);
  const TemporaryDirectory directory;
  Store copy =
      Store::create(directory.path() / "c.plait", plain.store.base(), options, default_backends());
  copy_levels(plain.store, copy);
  copy.commit();
  CHECK(digest(copy, {.threads = 3}).to_string() == digest(plain.store).to_string());
}

}  // namespace plait::test
