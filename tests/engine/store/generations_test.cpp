// What happens to levels of a committed version that are written anew: which files a version has,
// which files and extents stay for readers, and who is kept out.
#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "engine/store/sample_store.h"
#include "maintenance/repair_files.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "store/store_directory.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

namespace fs = std::filesystem;

const AttributeSchema kSchema{"position", ComponentType::kFloat32, 3};
constexpr int kGenerationLevels = 4;

/// A committed store of one attribute.
struct GenerationsPlace {
  explicit GenerationsPlace(const std::string& backend) {
    Store store = Store::create(path, BaseMesh::build(random_sheet(5, 40)), sample_options(backend),
                                default_backends());
    add_sample(store, kSchema, kGenerationLevels);
    store.commit();
  }
  Store open(bool writable = false) const {
    return Store::open(path, {.writable = writable, .durability = Durability::kNone},
                       default_backends());
  }
  bool has(const std::string& name) const { return fs::exists(path / name); }
  std::size_t versions() const {
    std::size_t count = 0;
    for (const std::string& name : file_names(path)) count += name.starts_with("version.");
    return count;
  }

  TemporaryDirectory directory{Medium::kMemory};
  fs::path path = directory.path() / "s.plait";
};

std::vector<std::string> backends_in_place() {
  std::vector<std::string> names = durable_backends();
  std::erase(names, "compressed");
  return names;
}

/// Writes `value` over one block of a level.
void fill_block(Store& store, int level, std::uint64_t block, std::byte value) {
  std::ranges::fill(StoreAccess::open_session(store)
                        .pin(StoreAccess::level_file(store, 0, level), block, Access::kOverwrite)
                        .bytes(),
                    value);
}

/// As a pass does, so the level gets a new generation.
void fill_level(Store& store, int level, std::byte value) {
  const LevelFile& file = StoreAccess::level_file(store, 0, level);
  file.backend->advise({0, file.geometry.block_count()}, Advice::kOverwrite);
  for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block)
    fill_block(store, level, block, value);
}

bool is_filled(Store& store, int level, std::byte value) {
  return std::ranges::all_of(read_level(store, 0, level), [=](std::byte b) { return b == value; });
}

}  // namespace

TEST_CASE("Generation_LevelOverwritten_HasANewFileAndTheOldOneGoesWithTheCommit") {
  for (const std::string& backend : backends_in_place()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    Store writer = place.open(true);
    fill_level(writer, 3, std::byte{7});
    StoreAccess::pager(writer).flush();
    CHECK(place.has("attribute0.level03.1"));
    CHECK(place.has("attribute0.level03.2"));
    CHECK_FALSE(place.has("attribute0.level02.2"));
    CHECK(is_filled(writer, 3, std::byte{7}));
    writer.commit();
    CHECK_FALSE(place.has("attribute0.level03.1"));
    CHECK(StoreAccess::level_file(writer, 0, 3).path == place.path / "attribute0.level03.2");
    CHECK(is_filled(writer, 3, std::byte{7}));
    fill_level(writer, 3, std::byte{8});
    writer.commit();
    CHECK(place.has("attribute0.level03.3"));
    CHECK_FALSE(place.has("attribute0.level03.2"));
    writer.close();
    Store reader = place.open();
    CHECK(is_filled(reader, 3, std::byte{8}));
    CHECK(read_level(reader, 0, 2) == sample_level(reader, kSchema, 2));
    CHECK(verify(reader).damaged_count == 0);
  }
}

TEST_CASE("Generation_BlocksThatWereNotOverwritten_AreReadFromTheirFile") {
  for (const std::string& backend : backends_in_place()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    std::vector<std::byte> expected;
    {
      Store writer = place.open(true);
      expected = read_level(writer, 0, kGenerationLevels);
      const LevelGeometry& geometry =
          StoreAccess::level_file(writer, 0, kGenerationLevels).geometry;
      REQUIRE(geometry.block_count() > 9);
      // What is left are single blocks, the first and the last among them, and a run.
      for (const std::uint64_t block :
           {std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{4}, geometry.block_count() - 2}) {
        fill_block(writer, kGenerationLevels, block, std::byte{9});
        const auto begin =
            expected.begin() + static_cast<std::ptrdiff_t>(geometry.block_offset(block));
        std::fill_n(begin, geometry.block_bytes(block), std::byte{9});
      }
      StoreAccess::pager(writer).flush();
      StoreAccess::pager(writer).discard();
      CHECK(read_level(writer, 0, kGenerationLevels) == expected);  // from both files
      writer.commit();
      CHECK(read_level(writer, 0, kGenerationLevels) == expected);
    }
    Store reader = place.open();
    CHECK(read_level(reader, 0, kGenerationLevels) == expected);
    CHECK(verify(reader).damaged_count == 0);
  }
}

TEST_CASE("Generation_WithoutACommit_LeavesTheOldFileAndNothingElse") {
  for (const std::string& backend : backends_in_place()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    const std::set<std::string> before = file_names(place.path);
    {
      Store writer = place.open(true);
      fill_level(writer, 3, std::byte{7});
      StoreAccess::pager(writer).flush();
    }
    CHECK(file_names(place.path) == before);
    Store reader = place.open();
    CHECK(holds_sample(reader, 0));
  }
}

TEST_CASE("Generation_NewFileThatCannotBeMade_IsAnErrorAndLeavesTheVersion") {
  const GenerationsPlace place("pread");
  {
    Store writer = place.open(true);
    fs::create_directory(place.path / "attribute0.level03.2");
    CHECK_THROWS_AS(
        [&] {
          fill_level(writer, 3, std::byte{7});
          writer.commit();
        }(),
        Error);
  }
  Store reader = place.open();
  CHECK(holds_sample(reader, 0));
}

TEST_CASE("Reader_WhileVersionsAreCommitted_KeepsItsOwnAndItsFiles") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    std::optional<Store> reader = place.open();
    Store writer = place.open(true);
    for (int version = 2; version < 12; ++version) {
      for (const int level : {2, 3, 4}) fill_level(writer, level, static_cast<std::byte>(version));
      writer.base_bytes(0)[0] ^= std::byte{1};
      writer.commit();
    }
    CHECK(holds_sample(*reader, 0));
    CHECK(verify(*reader).damaged_count == 0);
    CHECK(place.has("attribute0.level03.1"));
    CHECK(place.versions() == 3);
    // The next writer leaves them, too, and knows which bytes are not free.
    writer.close();
    writer = place.open(true);
    fill_level(writer, 3, std::byte{50});
    writer.commit();
    CHECK(holds_sample(*reader, 0));
    reader.reset();
    fill_level(writer, 3, std::byte{51});
    writer.commit();
    CHECK(place.versions() == 2);
    CHECK(place.has("attribute0.level03.1") == (backend == "compressed"));
    CHECK(is_filled(writer, 3, std::byte{51}));
    CHECK(is_filled(writer, 4, std::byte{11}));
    CHECK(verify(writer).damaged_count == 0);
  }
}

TEST_CASE("Reader_OfAVersionThatTheNextWritersFind_KeepsItsBytes") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    Store reader = place.open();
    // Each writer finds levels that the reader's version and the newest one have in common.
    for (int first_level = kGenerationLevels; first_level > 1; --first_level) {
      Store writer = place.open(true);
      for (const int mask : {0x55, 0x33, 0x0f}) {
        for (int level = first_level; level <= kGenerationLevels; ++level) {
          std::vector<std::byte> other = sample_level(writer, kSchema, level);
          for (std::byte& byte : other) byte ^= static_cast<std::byte>(mask);
          write_level(writer, 0, level, other);
        }
        writer.commit();
      }
    }
    CHECK(holds_sample(reader, 0));
    CHECK(verify(reader).damaged_count == 0);
  }
}

// The writer could not see the lock when it removed the files of version 1.
TEST_CASE("Reader_WhoseLockComesAfterACommit_OpensTheNewVersion") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    Store writer = place.open(true);
    fill_level(writer, 3, std::byte{7});
    const BeforeOperation commit(FileOperation::Kind::kLock, "version.1",
                                 [&] { CHECK_NOTHROW(writer.commit()); });
    Store reader = place.open();
    CHECK(commit.was_done());
    CHECK(reader.sequence() == 2);
    CHECK(is_filled(reader, 3, std::byte{7}));
  }
}

// A repair puts another file in its place: a lock on the former one would be seen by nobody.
TEST_CASE("Reader_WhoseVersionFileIsReplacedBeforeItsLock_LocksTheNewOne") {
  const GenerationsPlace place("pread");
  const fs::path file = place.path / "version.1", copy = place.path / "copy";
  fs::copy_file(file, copy);
  const BeforeOperation replace(FileOperation::Kind::kLock, "version.1",
                                [&] { fs::rename(copy, file); });
  const Store reader = place.open();
  CHECK(replace.was_done());
  CHECK(error_of([&] { hold_store(Directory(place.path)); }).code() == ErrorCode::kBusy);
}

TEST_CASE("Reader_ThatIsGone_GivesTheBytesOfItsVersionBack") {
  const GenerationsPlace place("compressed");
  const auto rewrite = [](Store& store, int times) {
    for (int round = 0; round < times; ++round) {
      fill_level(store, kGenerationLevels, static_cast<std::byte>(round));
      store.commit();
    }
    return StoreAccess::level_file(store, 0, kGenerationLevels).backend->stored_bytes();
  };
  Store writer = place.open(true);
  const std::uint64_t alone = rewrite(writer, 10);
  std::optional<Store> reader = place.open();
  const std::uint64_t beside_a_reader = rewrite(writer, 10);
  CHECK(is_filled(*reader, kGenerationLevels, std::byte{9}));
  reader.reset();
  rewrite(writer, 3);
  CHECK(rewrite(writer, 10) <= beside_a_reader);
  CHECK(beside_a_reader <= alone + alone);
}

TEST_CASE("HoldStore_WhileAReaderHasAnyVersion_IsBusy") {
  const GenerationsPlace place("pread");
  {
    const Store reader = place.open();
    place.open(true).commit();
    CHECK(error_of([&] { hold_store(Directory(place.path)); }).code() == ErrorCode::kBusy);
  }
  const std::vector<File> held = hold_store(Directory(place.path));
  CHECK(error_of([&] { place.open(); }).code() == ErrorCode::kBusy);
  CHECK(error_of([&] { place.open(true); }).code() == ErrorCode::kBusy);
}

TEST_CASE("ReplaceFile_WhileAReaderHasTheStore_IsBusy") {
  const GenerationsPlace place("pread");
  const Directory spare(place.directory.path());
  File(spare, "attribute0.base.1", OpenMode::kCreate).close();
  const Store reader = place.open();
  CHECK(error_of([&] { replace_file(place.path, 1, "attribute0.base.1", spare); }).code() ==
        ErrorCode::kBusy);
}

TEST_CASE("CheckStructure_WhileAWriterWorks_SeesTheCommittedVersion") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const GenerationsPlace place(backend);
    Store writer = place.open(true);
    fill_level(writer, 3, std::byte{7});
    StoreAccess::pager(writer).flush();
    const StoreCheck check = check_store(place.path, default_backends());
    CHECK(check.sequence == 1);
    CHECK(check.damaged.empty());
  }
}
