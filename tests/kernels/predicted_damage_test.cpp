// Stores with predicted blocks (docs/made-blocks.md) that are killed, cancelled, read by many
// threads, or made by somebody who means harm.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/store/forge.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/killing_operations.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::predicted_damage_test {
namespace {

namespace fs = std::filesystem;
using DamagedPoint = Vector3<float>;

SubdivideOptions to_level(int levels) {
  return {.executor = ExecutorKind::kFused, .levels = levels, .normals = true};
}

Store refined_to_damage(const fs::path& path, const BaseMesh& base, int levels,
                        Durability durability = Durability::kNone) {
  StoreOptions options{.backend = path.empty() ? "memory" : "compressed"};
  if (!path.empty()) options.pipeline = "predicted,zstd:1";
  options.block_bytes = 4096;
  options.budget_bytes = 16 << 20;
  options.durability = durability;
  Store store = Store::create(path, base, options, default_backends());
  add_base_positions(store);
  subdivide(store, to_level(levels));
  store.commit();
  return store;
}

BaseMesh torus() { return BaseMesh::build(torus_grid(6, 5)); }

std::uint64_t predicted_blocks(const Store& store) {
  std::uint64_t count = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = 1; level <= store.attributes()[id].finest_level; ++level)
      for (const BlockEntry& entry : StoreAccess::level_file(store, id, level).table.entries())
        count += entry.encoding == BlockEncoding::kPredicted ? 1u : 0u;
  return count;
}

/// Changes one block, encodes the normals anew, and commits.
void change(const fs::path& path) {
  Store store = Store::open(path, {.writable = true}, default_backends());
  {
    const PinnedBlock pinned = StoreAccess::open_session(store).pin(
        StoreAccess::level_file(store, 0, 2), 0, Access::kUpdate);
    pinned.bytes()[5] ^= std::byte{1};
  }
  recode_attribute(store, 1, "predicted,lz4");
  store.commit();
}

/// The digest of a store that is opened and verified, for reading and for writing.
std::string word_of(const fs::path& path) {
  std::string word;
  for (const bool writable : {false, true}) {
    Store store = Store::open(path, {.writable = writable}, default_backends());
    CHECK(verify(store).damaged_count == 0);
    const std::string found = digest(store).to_string();
    CHECK((word.empty() || found == word));
    word = found;
  }
  return word;
}

}  // namespace

TEST_CASE("Predicted_KilledBeforeAnyOperationOfACommit_LeavesTheOldVersionOrTheNewOne") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait", victim = directory.path() / "v.plait";
  { CHECK(predicted_blocks(refined_to_damage(path, torus(), 2, Durability::kCommit)) > 0); }
  const std::string before = word_of(path);
  fs::copy(path, victim);
  change(victim);
  const std::string after = word_of(victim);
  REQUIRE(before != after);
  bool found_before = false, found_after = false;
  bool killed = true;
  for (std::uint64_t operations = 0; killed; operations += 7) {
    fs::remove_all(victim);
    fs::copy(path, victim);
    killed = run_and_kill_before(operations, [&] { change(victim); });
    const std::string found = word_of(victim);
    CAPTURE(operations);
    CHECK((found == before || found == after));
    found_before |= found == before;
    found_after |= found == after;
  }
  CHECK(found_before);
  CHECK(found_after);
}

TEST_CASE("Predicted_KilledWhileItIsMade_LeavesNoStoreOrAWholeOne") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const BaseMesh base = torus();
  Store expected = refined_to_damage({}, base, 2);
  const std::string whole = digest(expected).to_string();
  bool killed = true;
  for (std::uint64_t operations = 0; killed; operations += 5) {
    fs::remove_all(path);
    killed = run_and_kill_before(operations,
                                 [&] { refined_to_damage(path, base, 2, Durability::kCommit); });
    CAPTURE(operations);
    if (fs::exists(path) && Store::has_commit(path)) CHECK(word_of(path) == whole);
    if (!killed) CHECK(word_of(path) == whole);
  }
}

TEST_CASE("Predicted_CancelledInTheMidst_KeepsTheLastCommit") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  { refined_to_damage(path, torus(), 2); }
  const std::string before = word_of(path);
  const int calls = GENERATE(0, 1, 2);
  {
    // The new levels, half of them written.
    Store store = Store::open(path, {.writable = true}, default_backends());
    SubdivideOptions further = to_level(3);
    further.executor = ExecutorKind::kSweep;
    int left = calls;
    further.progress = [&](const Progress&) { return left-- > 0; };
    CHECK_THROWS_AS(subdivide(store, further), Error);
    // Before the first level is added, nothing is unfinished.
    if (calls > 1) CHECK_THROWS_AS(store.commit(), Error);
  }
  CHECK(word_of(path) == before);
  {
    // A recoding leaves the attribute as it was, and the store can be committed.
    Store store = Store::open(path, {.writable = true}, default_backends());
    int left = calls % 2;
    RecodeOptions recoding;
    recoding.progress = [&](const Progress&) { return left-- > 0; };
    CHECK_THROWS_AS(recode_attribute(store, 0, "predicted+hierarchy+shuffle,zstd:1", recoding),
                    Error);
    store.commit();
    CHECK(predicted_blocks(store) > 0);
  }
  CHECK(word_of(path) == before);
}

TEST_CASE("Predicted_PatchesReadByManyThreadsInASmallBudget_AreThoseOfTheScheme") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const BaseMesh base = BaseMesh::build(torus_grid(10, 8));
  { refined_to_damage(path, base, 4); }
  const Store expected = refined_to_damage({}, base, 4);
  const OpenOptions open{.budget_bytes = 1 << 20};
  const Store store = Store::open(path, open, default_backends());
  const Reader reader(store), oracle(expected);
  const auto faces = static_cast<FaceId>(base.face_count());
  std::vector<std::uint64_t> wrong(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t worker = 0; worker < wrong.size(); ++worker)
      threads.emplace_back([&, worker] {
        for (FaceId i = 0; i < faces; ++i) {
          const FaceId face = (i * 37 + static_cast<FaceId>(worker) * 41) % faces;
          const PatchView found = reader.read_patch(face, 4), right = oracle.read_patch(face, 4);
          for (const char* const name : {"position", "normal"}) {
            std::vector<std::byte> a(patch_vertex_count(found.size()) * sizeof(DamagedPoint)),
                b(a.size());
            found.records(name).copy_to(a);
            right.records(name).copy_to(b);
            wrong[worker] += a == b ? 0u : 1u;
          }
        }
      });
  }
  CHECK(wrong == std::vector<std::uint64_t>(4, 0));
}

TEST_CASE("Predicted_HostileRecipe_IsANamedErrorOfTheBlock") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait", victim = directory.path() / "v.plait";
  { refined_to_damage(path, torus(), 3); }
  const std::string recipes[] = {"nobody/position/float32/3",
                                 "loop/position/float32/20",
                                 "loop/position/float32/2",  // the level itself is finer
                                 "loop/position/float32/21",
                                 "loop/position/float32/-3",
                                 "loop/position/float32/99999999999999999999999",
                                 "loop/normal/float32/3",  // of another attribute
                                 "loop/limit/float32/3",
                                 "midpoint/position/float32/3",
                                 "loop/position/float64/3",
                                 "loop/position/int64/3",
                                 "//////////",
                                 std::string(60000, '/'),
                                 std::string(60000, 'x')};
  for (const std::string& recipe : recipes) {
    CAPTURE(recipe.substr(0, 60));
    fs::remove_all(victim);
    fs::copy(path, victim);
    forge_description(victim, [&](VersionDescription& version) {
      for (LevelRecord& level : version.attributes[0].levels)
        level.pipeline = "predicted:" + recipe + ",zstd:1";
    });
    // Either the store is refused, or each of these blocks.
    std::string refusal;
    try {
      const Store store = Store::open(victim, {}, default_backends());
      const LevelFile& level = StoreAccess::level_file(store, 0, 3);
      for (std::uint64_t block = 0; block < level.table.size(); ++block) {
        REQUIRE(level.table[block].encoding == BlockEncoding::kPredicted);
        try {
          static_cast<void>(StoreAccess::open_session(store).pin(level, block));
          FAIL("a block was made by another recipe, and returned");
        } catch (const Error& error) {
          CHECK(
              (error.code() == ErrorCode::kCorruption || error.code() == ErrorCode::kNotSupported));
          refusal = error.what();
        }
      }
    } catch (const Error& error) {
      CHECK((error.code() == ErrorCode::kCorruption || error.code() == ErrorCode::kNotSupported));
      refusal = error.what();
    }
    CHECK_THAT(refusal, Catch::Contains(victim.string()));
    CHECK(refusal.size() < 2000);
  }
}

TEST_CASE("Predicted_EntryOfABlockThatNothingMakes_IsANamedErrorOfTheBlock") {
  // A vertex of 256 faces, and a level without a recipe: no block there was ever predicted.
  const bool has_hub = GENERATE(true, false);
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const BaseMesh base = BaseMesh::build(has_hub ? closed_fan(256) : torus_grid(6, 5));
  {
    Store store = refined_to_damage(path, base, 2);
    if (!has_hub) recode_attribute(store, 0, "zstd:1");
    store.commit();
  }
  std::vector<std::byte> version = whole_file(version_file(path));
  for (std::size_t at = tables_offset(version); at + sizeof(BlockEntry) <= version.size();
       at += sizeof(BlockEntry)) {
    BlockEntry entry;
    std::memcpy(&entry, version.data() + at, sizeof entry);
    entry.offset = 0;
    entry.stored_bytes = 0;
    entry.encoding = BlockEncoding::kPredicted;
    std::memcpy(version.data() + at, &entry, sizeof entry);
  }
  forge_version_file(path, version);
  const Store store = Store::open(path, {}, default_backends());
  const AttributeId attribute = has_hub ? 0 : store.attribute("position");
  for (int level = 1; level <= 2; ++level) {
    try {
      static_cast<void>(StoreAccess::open_session(store).pin(
          StoreAccess::level_file(store, attribute, level), 0));
      FAIL("a block that nothing makes was returned");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kNotSupported);
      CHECK_THAT(error.what(), Catch::Contains("cannot be made again"));
      CHECK_THAT(error.what(), Catch::Contains(path.string()));
    }
  }
}

}  // namespace plait::test::predicted_damage_test
