#include "plait/extend/block_table.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "plait/error.h"

namespace plait {
namespace {

StoreUuid counting_uuid() {
  StoreUuid uuid;
  for (std::size_t i = 0; i < uuid.size(); ++i) uuid[i] = static_cast<std::byte>(i);
  return uuid;
}

std::vector<std::byte> counting_bytes(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7 + 3);
  return bytes;
}

std::string error_of_check(const BlockTable& table, std::uint64_t block,
                           std::span<const std::byte> bytes) {
  try {
    table.check(block, bytes, "dir/level");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruption);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("BlockTable_New_HasNeverWrittenEntries") {
  const BlockTable table(counting_uuid(), 1, 2, 3);
  REQUIRE(table.size() == 3);
  for (const BlockEntry& entry : table.entries()) {
    CHECK(entry.encoding == BlockEncoding::kNeverWritten);
    CHECK(entry.offset == 0);
    CHECK(entry.stored_bytes == 0);
  }
  // Such a block is zeros, and nothing else.
  CHECK(table.matches(0, std::vector<std::byte>(100)));
  CHECK_FALSE(table.matches(0, counting_bytes(100)));
  CHECK(error_of_check(table, 1, counting_bytes(5)).find("never written") != std::string::npos);
}

TEST_CASE("BlockTableSeal_Checksum_IsTheOneOfTheFormat") {
  // From a Python program that follows docs/format.md: XXH3-64 of libxxhash through ctypes, the
  // identity packed with struct ("<II" and "<Q").
  BlockTable table(counting_uuid(), 5, 3, 10);
  table.seal(7, 4096, BlockEncoding::kEncoded, counting_bytes(1000));
  CHECK(table[7].checksum == 0xb87923aef07b7d47u);
  CHECK(table[7].offset == 4096);
  CHECK(table[7].stored_bytes == 1000);
  CHECK(table[7].encoding == BlockEncoding::kEncoded);
}

TEST_CASE("BlockTableMatches_AnyOtherIdentity_DoesNot") {
  const auto bytes = counting_bytes(500);
  BlockTable table(counting_uuid(), 5, 3, 10);
  table.seal(4, 0, BlockEncoding::kRaw, bytes);
  CHECK(table.matches(4, bytes));
  CHECK(error_of_check(table, 4, bytes).empty());

  StoreUuid other_uuid = counting_uuid();
  other_uuid[15] ^= std::byte{1};
  BlockTable others[] = {{other_uuid, 5, 3, 10},
                         {counting_uuid(), 6, 3, 10},
                         {counting_uuid(), 5, 4, 10},
                         {counting_uuid(), 3, 5, 10}};
  for (BlockTable& other : others) {
    other.entries()[4] = table[4];
    CHECK_FALSE(other.matches(4, bytes));
  }
  table.entries()[5] = table[4];
  CHECK_FALSE(table.matches(5, bytes));
}

TEST_CASE("BlockTableCheck_AnyFlippedBitOrOtherSize_IsFound") {
  auto bytes = counting_bytes(50);
  BlockTable table(counting_uuid(), 0, 1, 1);
  table.seal(0, 512, BlockEncoding::kRaw, bytes);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    CHECK_FALSE(table.matches(0, bytes));
    bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
  }
  CHECK(table.matches(0, bytes));
  CHECK_FALSE(table.matches(0, std::span(bytes).first(49)));
  CHECK_FALSE(table.matches(0, {}));

  CHECK(error_of_check(table, 0, std::span(bytes).first(49)) ==
        "read dir/level: attribute 0 level 1 block 0 at byte 512: expected 50 stored bytes, found "
        "49");
  bytes[0] ^= std::byte{1};
  const std::string message = error_of_check(table, 0, bytes);
  CHECK(message.find("dir/level: attribute 0 level 1 block 0 at byte 512: expected checksum ") !=
        std::string::npos);
}

TEST_CASE("BlockEntry_InMemory_IsTheStoredLayout") {
  CHECK(offsetof(BlockEntry, offset) == 0);
  CHECK(offsetof(BlockEntry, stored_bytes) == 8);
  CHECK(offsetof(BlockEntry, encoding) == 12);
  CHECK(offsetof(BlockEntry, checksum) == 16);
}

}  // namespace plait
