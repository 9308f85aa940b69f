// The change log of a store: what a stranger reads, damage and forged records, readers beside a
// writer.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/forge.h"
#include "engine/store/format_reader.h"
#include "engine/store/sample_store.h"
#include "format/change_record.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::change_log_test {
namespace {

namespace fs = std::filesystem;

const AttributeSchema kPosition{"position", ComponentType::kFloat32, 3},
    kNumber{"number", ComponentType::kUint16, 1};
constexpr int kLevels = 4;

struct Content {
  std::vector<std::vector<std::byte>> base, levels;
  friend bool operator==(const Content&, const Content&) = default;
};

Content content_of(Store& store) {
  Content content;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const auto base = std::as_const(store).base_bytes(id);
    content.base.emplace_back(base.begin(), base.end());
    for (int level = 1; level <= kLevels; ++level)
      content.levels.push_back(read_level(store, id, level));
  }
  return content;
}

void fill_block(Store& store, AttributeId id, int level, std::uint64_t block, int value) {
  std::ranges::fill(StoreAccess::open_session(store)
                        .pin(StoreAccess::level_file(store, id, level), block, Access::kOverwrite)
                        .bytes(),
                    static_cast<std::byte>(value));
}

/// A store with versions 1 to 5, of which the last three are records in the log of version 2.
struct Place {
  explicit Place(const std::string& backend = "pread") {
    {
      Store store = Store::create(path, BaseMesh::build(random_sheet(5, 40)),
                                  sample_options(backend), default_backends());
      add_sample(store, kPosition, kLevels);
      add_sample(store, kNumber, kLevels);
      store.commit();
    }
    Store store = Store::open(path, {true}, default_backends());
    for (int version = 2; version <= 5; ++version) {
      fill_block(store, 0, 4, static_cast<std::uint64_t>(version), version);
      fill_block(store, 0, 4, 1, version);
      fill_block(store, 1, version - 1, 0, version);
      store.base_bytes(1)[static_cast<std::size_t>(version)] ^= std::byte{1};
      store.commit();
    }
    content = content_of(store);
  }
  Manifest manifest() const { return read_manifest(Directory(path)); }
  Store open() const { return Store::open(path, {}, default_backends()); }
  /// Changes the newest record, and makes its checksum right.
  void forge(const std::function<void(ChangeRecord&)>& change) const {
    Manifest manifest = this->manifest();
    File log(path / "changes.2", OpenMode::kReadWrite);
    ChangeRecord record = read_change_records(log, manifest, 1000).back();
    change(record);
    const std::vector<std::byte> bytes = encode_change_record(record);
    log.write_at(manifest.log.last_record, bytes);
    std::memcpy(&manifest.log.last_checksum, &bytes[bytes.size() - 8], 8);
    manifest.log.bytes = std::max(manifest.log.bytes, manifest.log.last_record + bytes.size());
    File file(path / kManifestName, OpenMode::kReadWrite);
    write_manifest(file, manifest);
  }

  TemporaryDirectory directory;
  fs::path path = directory.path() / "s.plait";
  Content content;
};

}  // namespace

TEST_CASE("ChangeLog_OfAStore_IsReadByAStranger") {
  for (const std::string backend : {"pread", "uring", "mmap"}) {
    CAPTURE(backend);
    const Place place(backend);
    CHECK(place.manifest().described == 2);
    CHECK(place.manifest().sequence == 5);
    const format::Store read = format::read_store(place.path);
    CHECK(read.sequence == 5);
    for (std::size_t id = 0; id < 2; ++id) {
      CHECK(std::ranges::equal(read.attributes[id].base, place.content.base[id], {}, {},
                               [](std::byte b) { return std::to_integer<unsigned char>(b); }));
      for (std::uint32_t level = 1; level <= kLevels; ++level)
        CHECK(std::ranges::equal(read.attributes[id].levels.at(level),
                                 place.content.levels[id * kLevels + level - 1], {}, {},
                                 [](std::byte b) { return std::to_integer<unsigned char>(b); }));
    }
    Store store = place.open();
    CHECK(content_of(store) == place.content);
    CHECK(check_store(place.path, default_backends()).damaged.empty());
  }
}

TEST_CASE("ChangeLog_AnyByteFlipped_IsDetectedOrMakesNoDifference") {
  const Place place;
  const std::vector<std::byte> whole = whole_file(place.path / "changes.2");
  std::size_t detected = 0;
  for (std::size_t at = 0; at < place.manifest().log.bytes; at += 61) {
    std::vector<std::byte> bytes = whole;
    bytes[at] ^= std::byte{0x40};
    write_whole(place.path / "changes.2", bytes);
    try {
      Store store = place.open();
      if (verify(store).damaged_count > 0)
        ++detected;
      else
        REQUIRE(content_of(store) == place.content);
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kCorruption);
      REQUIRE(names(error, {"changes.2"}));
      ++detected;
    }
  }
  CHECK(detected > 50);
}

TEST_CASE("ChangeLog_ForgedRecord_IsRefusedByName") {
  const auto refused = [](const std::function<void(ChangeRecord&)>& change) {
    const Place place;
    place.forge([](ChangeRecord&) {});
    {
      Store store = place.open();  // a record that is written again as it was
      REQUIRE(content_of(store) == place.content);
    }
    place.forge(change);
    const Error error = error_of([&] { place.open(); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {"changes.2"}));
    const StoreCheck check = check_store(place.path, default_backends());
    CHECK_FALSE(check.damaged.empty());
  };
  refused([](ChangeRecord& record) { record.version = 4; });
  refused([](ChangeRecord& record) { record.before = 0; });
  refused([](ChangeRecord& record) { record.before += kLogAlignment; });
  refused([](ChangeRecord& record) { record.before_checksum ^= 1; });
  refused([](ChangeRecord& record) { record.blocks[0].attribute = 7; });
  refused([](ChangeRecord& record) { record.blocks[0].level = 9; });
  refused([](ChangeRecord& record) { record.blocks[0].block = 1u << 30; });
  refused([](ChangeRecord& record) { record.blocks[0].offset += 8; });
  refused([](ChangeRecord& record) { record.blocks[0].offset = std::uint64_t{1} << 40; });
  refused([](ChangeRecord& record) { record.records[0].first = ~std::uint64_t{0}; });
  refused([](ChangeRecord& record) { record.records[0].bytes = std::uint64_t{1} << 40; });
  refused([](ChangeRecord& record) { record.records[0].checksum ^= 1; });
  refused([](ChangeRecord& record) { record.blocks.resize(100'000, record.blocks.front()); });
}

TEST_CASE("ChangeLog_CutShortOrMissing_IsNamedAndNothingIsRepairedFromIt") {
  const bool missing = GENERATE(false, true);
  const Place place;
  if (missing)
    fs::remove(place.path / "changes.2");
  else
    fs::resize_file(place.path / "changes.2", place.manifest().log.bytes - 1);
  CHECK(names(error_of([&] { place.open(); }), {"changes.2"}));
  const StoreCheck check = check_store(place.path, default_backends());
  REQUIRE_FALSE(check.damaged.empty());
  CHECK(check.damaged[0].kind == StoreFile::kChangeLog);
  CHECK(check.damaged[0].name == "changes.2");
  const RepairReport report = repair(place.path, {}, default_backends());
  CHECK_FALSE(report.whole());
  CHECK(report.lost_files[0].name == "changes.2");
}

TEST_CASE("ChangeLog_LeftByAKilledWriter_IsRemovedByTheNext") {
  const Place place;
  std::ofstream(place.path / "changes.6") << "left";
  CHECK(check_store(place.path, default_backends()).left_over ==
        std::vector<std::string>{"changes.6"});
  Store store = Store::open(place.path, {true}, default_backends());
  CHECK_FALSE(fs::exists(place.path / "changes.6"));
  CHECK(fs::exists(place.path / "changes.2"));
}

TEST_CASE("ChangeLog_ReaderOfAnEarlierRecord_KeepsItWhileLogsComeAndGo") {
  for (const std::string backend : {"pread", "uring", "mmap"}) {
    CAPTURE(backend);
    const Place place(backend);
    std::optional<Store> reader = place.open();
    Store writer = Store::open(place.path, {true}, default_backends());
    for (int commit = 0; commit < 60; ++commit) {
      fill_block(writer, 0, 4, 1, commit);
      fill_block(writer, 0, 4, static_cast<std::uint64_t>(commit) % 12, commit);
      writer.commit();
    }
    CHECK(place.manifest().log.generation > 2);
    CHECK(fs::exists(place.path / "changes.2"));
    CHECK(content_of(*reader) == place.content);
    CHECK(verify(*reader).damaged_count == 0);
    const Content now = content_of(writer);
    reader.reset();
    writer.close();
    CHECK_FALSE(fs::exists(place.path / "changes.2"));
    Store store = place.open();
    CHECK(content_of(store) == now);
    CHECK(check_store(place.path, default_backends()).left_over.empty());
  }
}

TEST_CASE("ChangeLog_RolledBack_HasTheCommittedVersionAndGoesOn") {
  const Place place;
  Store store = Store::open(place.path, {true}, default_backends());
  for (std::uint64_t block = 0; block < 4; ++block) fill_block(store, 0, 4, block, 99);
  StoreAccess::pager(store).flush();
  store.roll_back();
  CHECK(content_of(store) == place.content);
  fill_block(store, 0, 4, 0, 77);
  store.commit();
  const Content now = content_of(store);
  Store reader = place.open();
  CHECK(content_of(reader) == now);
}

}  // namespace plait::test::change_log_test
