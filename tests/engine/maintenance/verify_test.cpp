// verify(): every damaged block is named with its place, and nothing else is.
#include "plait/verify.h"

#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Two attributes with levels 1 to 3, of several blocks each.
std::filesystem::path make_store(const TemporaryDirectory& directory, const std::string& backend) {
  const std::filesystem::path path = directory.path() / "s.plait";
  Store store = Store::create(path, BaseMesh::build(random_sheet(5, 120)), sample_options(backend),
                              default_backends());
  add_sample(store, sample_schemas()[0], 3);
  add_sample(store, sample_schemas()[5], 3);
  store.commit();
  return path;
}

Store open(const std::filesystem::path& path) {
  return Store::open(path, {.writable = false, .budget_bytes = 1 << 20}, default_backends());
}

void flip_in_file(const std::filesystem::path& file, std::uint64_t offset) {
  overwrite_byte(file, offset, file_bytes(file)[offset] ^ std::byte{0x10});
}

}  // namespace

TEST_CASE("Verify_HealthyStore_ReadsEveryBlockOnce") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory directory;
    Store store = open(make_store(directory, backend));
    std::uint64_t blocks = 0, bytes = 0;
    for (AttributeId id = 0; id < 2; ++id)
      for (int level = 1; level <= 3; ++level) {
        blocks += StoreAccess::level_file(store, id, level).geometry.block_count();
        bytes += StoreAccess::level_file(store, id, level).geometry.total_bytes();
      }
    std::uint64_t last_done = 0, last_total = 0, calls = 0;
    const VerifyReport report = verify(store, [&](const Progress& now) {
      CHECK(now.done > last_done);
      last_done = now.done;
      last_total = now.total;
      ++calls;
      return true;
    });
    CHECK(report.blocks == blocks);
    CHECK(report.bytes == bytes);
    CHECK(report.never_written == 0);
    CHECK(report.damaged_count == 0);
    CHECK(report.damaged.empty());
    CHECK(calls == blocks);
    CHECK(last_done == bytes);
    CHECK(last_total == bytes);
  }
}

TEST_CASE("Verify_FlippedByteInAnyBlock_NamesThatBlock") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = make_store(directory, backend);
    for (AttributeId id = 0; id < 2; ++id)
      for (int level = 1; level <= 3; ++level) {
        const std::uint64_t blocks =
            StoreAccess::level_file(open(path), id, level).geometry.block_count();
        if (level == 3) REQUIRE(blocks > 3);
        for (const std::uint64_t block : std::set<std::uint64_t>{0, blocks / 2, blocks - 1}) {
          std::filesystem::path file;
          BlockEntry entry;
          {
            const Store store = open(path);
            file = StoreAccess::level_file(store, id, level).path;
            entry = StoreAccess::level_file(store, id, level).table[block];
          }
          for (const std::uint64_t offset : {entry.offset, entry.offset + entry.stored_bytes - 1}) {
            flip_in_file(file, offset);
            Store store = open(path);
            const VerifyReport report = verify(store);
            INFO(backend << " attribute " << id << " level " << level << " block " << block);
            CHECK(report.damaged_count == 1);
            REQUIRE(report.damaged.size() == 1);
            const DamagedBlock& damaged = report.damaged[0];
            const LevelGeometry& geometry = StoreAccess::level_file(store, id, level).geometry;
            CHECK(damaged.attribute == store.attributes()[id].schema.name);
            CHECK(damaged.level == level);
            CHECK(damaged.block == block);
            CHECK(damaged.file_offset == entry.offset);
            CHECK(damaged.first_edge == geometry.first_edge(block));
            CHECK(damaged.edge_after == geometry.edge_after(block));
            CHECK(damaged.reason.find(file.string()) != std::string::npos);
            flip_in_file(file, offset);
          }
        }
      }
    Store store = open(path);
    CHECK(verify(store).damaged_count == 0);
  }
}

TEST_CASE("Read_OfADamagedBlock_SaysWhatHelpsAndVerifyNamesOnlyThePlace") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    Store store = open(make_store(directory, backend));
    const LevelFile& level = StoreAccess::level_file(std::as_const(store), 0, 3);
    flip_in_file(level.path, level.table[1].offset);
    const Error error = error_of([&] { read_level(store, 0, 3); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK_THAT(error.what(), Catch::EndsWith("; `plait repair` (plait::repair) mends what it can"));
    const VerifyReport report = verify(store);
    REQUIRE(report.damaged.size() == 1);
    CHECK_THAT(report.damaged[0].reason, !Catch::Contains("repair"));
  }
}

TEST_CASE("Verify_SeveralDamagedBlocks_NamesAllOfThem") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = make_store(directory, backend);
    std::uint64_t expected = 0;
    for (AttributeId id = 0; id < 2; ++id)
      for (int level = 1; level <= 3; ++level) {
        const Store store = open(path);
        const LevelFile& file = StoreAccess::level_file(store, id, level);
        for (std::uint64_t block = 0; block < file.table.size(); block += 2, ++expected)
          flip_in_file(file.path, file.table[block].offset + 1);
      }
    Store store = open(path);
    const VerifyReport report = verify(store);
    CHECK(report.damaged_count == expected);
    CHECK(report.damaged.size() == expected);
  }
}

TEST_CASE("Verify_NeverWrittenBlock_IsZerosWhateverTheFileHolds") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory.path() / "s.plait";
    {
      Store store = Store::create(path, BaseMesh::build(icosahedron()), sample_options(backend),
                                  default_backends());
      store.add_level(store.add_attribute(sample_schemas()[0]));
      store.commit();
    }
    {
      Store store = open(path);
      const VerifyReport report = verify(store);
      CHECK(report.blocks == 1);
      CHECK(report.never_written == 1);
      CHECK(report.damaged_count == 0);
    }
    if (backend == "compressed") continue;  // the file is empty
    flip_in_file(path / "attribute0.level01.1", 100);
    Store store = open(path);
    CHECK(verify(store).damaged_count == 0);
    const std::vector<std::byte> zeros(StoreAccess::level_file(store, 0, 1).geometry.total_bytes());
    CHECK(read_level(store, 0, 1) == zeros);
  }
}

TEST_CASE("Verify_Cancelled_Throws") {
  const TemporaryDirectory directory;
  Store store = open(make_store(directory, "pread"));
  int calls = 0;
  const Error error =
      error_of([&] { verify(store, [&](const Progress&) { return ++calls < 3; }); });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(calls == 3);
}
