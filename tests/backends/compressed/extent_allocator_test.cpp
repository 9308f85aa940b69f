#include "compressed/extent_allocator.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "plait/error.h"

namespace plait::test {
namespace {

BlockEntry entry_at(std::uint64_t offset, std::uint32_t bytes) {
  return {offset, bytes, BlockEncoding::kEncoded, 0};
}

}  // namespace

TEST_CASE("ExtentAllocator_OpenedTable_KeepsItsExtentsUntilClosed") {
  // | 0: 700 bytes | free 1024..2048 | 1: 512 bytes | 2560
  std::vector<BlockEntry> table = {entry_at(0, 700), entry_at(2048, 512), BlockEntry{}};
  {
    ExtentAllocator extents(table, 2560, "level");
    CHECK(extents.end_bytes() == 2560);
    extents.replace(0, table[0]);  // held: its bytes are the last version's
    CHECK(extents.allocate(700) == 1024);
    CHECK(extents.allocate(700) == 2560);
    CHECK(extents.end_bytes() == 3584);
    extents.replace(0, entry_at(1024, 700));  // given out since: free again
    CHECK(extents.allocate(900) == 1024);
  }
  table[0] = entry_at(2560, 700);
  ExtentAllocator reopened(table, 3300, "level");
  CHECK(reopened.end_bytes() == 3584);
  CHECK(reopened.allocate(2048) == 0);
}

TEST_CASE("ExtentAllocator_Versions_KeepTheirExtentsUntilTheNextOneIsThere") {
  ExtentAllocator extents(std::vector<BlockEntry>(1), 0, "level");
  std::vector<BlockEntry> table = {entry_at(extents.allocate(512), 512)};
  extents.begin_version(1, {});  // version 1, at 0
  CHECK(extents.allocate(512) == 512);
  extents.replace(0, table[0]);
  table[0].offset = 512;
  CHECK(extents.allocate(512) == 1024);
  extents.replace(0, table[0]);  // of no version: free
  table[0].offset = 1024;
  CHECK(extents.allocate(512) == 512);
  extents.begin_version(2, {});  // version 2, at 1024; version 1 is the other slot's, and stays
  CHECK(extents.allocate(512) == 1536);
  extents.replace(0, table[0]);
  table[0].offset = 1536;
  extents.begin_version(3, {});  // version 3, so that 1 may go
  CHECK(extents.allocate(512) == 0);
  CHECK(extents.allocate(512) == 2048);
}

TEST_CASE("ExtentAllocator_VersionThatAReaderHas_KeepsItsExtentsUntilTheReaderIsGone") {
  ExtentAllocator extents(std::vector<BlockEntry>(2), 0, "level");
  std::vector<BlockEntry> table = {entry_at(extents.allocate(512), 512),
                                   entry_at(extents.allocate(512), 512)};
  const auto rewrite = [&](std::uint64_t block) {
    const std::uint64_t offset = extents.allocate(512);
    extents.replace(block, table[block]);
    return table[block].offset = offset;
  };
  extents.begin_version(1, {});
  CHECK(rewrite(0) == 1024);
  const std::vector<std::uint64_t> none, first = {1};
  extents.begin_version(2, first);
  CHECK(rewrite(0) == 1536);
  extents.begin_version(3, first);
  CHECK(rewrite(0) == 2048);
  // A reader has version 1, at 0. Version 2, at 1024, nobody has.
  extents.begin_version(4, first);
  CHECK(rewrite(0) == 1024);
  extents.begin_version(5, none);
  CHECK(rewrite(0) == 0);
  CHECK(rewrite(1) == 1536);
}

TEST_CASE("ExtentAllocator_OpenedWhileReadersHaveOlderVersions_KeepsTheirExtents") {
  const auto table_of = [](std::vector<BlockEntry> entries) {
    BlockTable table({}, 0, 1, entries.size());
    std::ranges::copy(entries, table.entries().begin());
    return table;
  };
  const std::vector<BlockEntry> newest = {entry_at(1024, 512), entry_at(512, 512)};
  const BlockTable third = table_of({entry_at(0, 512), entry_at(512, 512)});
  const BlockTable fifth = table_of({entry_at(0, 512), entry_at(2048, 512)});
  const std::vector<HeldTable> held = {{3, &third}, {5, &fifth}};
  ExtentAllocator extents(newest, 2560, "level", held);
  CHECK(extents.allocate(512) == 1536);
  CHECK(extents.allocate(512) == 2560);
  const std::vector<std::uint64_t> only_third = {3};
  extents.begin_version(8, only_third);
  CHECK(extents.allocate(512) == 2048);
  extents.begin_version(9, {});
  CHECK(extents.allocate(512) == 0);
  // What two versions have differently, and in the same place, no writer has made.
  const BlockTable wrong = table_of({entry_at(1024, 600), entry_at(512, 512)});
  const std::vector<HeldTable> contradiction = {{3, &wrong}};
  CHECK_THROWS_AS(ExtentAllocator(newest, 2560, "level", contradiction), Error);
}

TEST_CASE("ExtentAllocator_ReleasedNeighbours_BecomeOne") {
  ExtentAllocator extents({}, 0, "level");
  for (std::uint64_t i = 0; i < 6; ++i) REQUIRE(extents.allocate(512) == 512 * i);
  extents.release(512, 512);
  extents.release(1536, 512);
  extents.release(1024, 1);
  CHECK(extents.allocate(1536) == 512);
  extents.release(2560, 512);
  CHECK(extents.end_bytes() == 2560);
  extents.release(512, 1536);
  extents.release(2048, 512);
  CHECK(extents.end_bytes() == 512);
}

TEST_CASE("ExtentAllocator_SeveralFreeExtents_TakesTheSmallestThatFits") {
  ExtentAllocator extents({}, 0, "level");
  const std::uint64_t large = extents.allocate(4096);
  extents.allocate(512);
  const std::uint64_t small = extents.allocate(1024);
  extents.allocate(512);
  extents.release(large, 4096);
  extents.release(small, 1024);
  CHECK(extents.allocate(1000) == small);
  CHECK(extents.allocate(1000) == large);
  CHECK(extents.allocate(3072) == large + 1024);
}

TEST_CASE("ExtentAllocator_RandomUse_NeverOverlaps") {
  std::mt19937 random(11);
  ExtentAllocator extents({}, 0, "level");
  struct Extent {
    std::uint64_t offset, bytes;
  };
  std::vector<Extent> live;
  std::uint64_t most_bytes = 0, live_bytes = 0;
  for (int round = 0; round < 20000; ++round) {
    if (live.size() > 50 || (!live.empty() && random() % 3 == 0)) {
      std::swap(live[random() % live.size()], live.back());
      extents.release(live.back().offset, live.back().bytes);
      live_bytes -= (live.back().bytes + 511) / 512 * 512;
      live.pop_back();
      continue;
    }
    const std::uint64_t bytes = 1 + random() % 10000;
    const std::uint64_t offset = extents.allocate(bytes);
    bool good = offset % 512 == 0 && offset + bytes <= extents.end_bytes();
    for (const Extent& other : live)
      good = good && (offset >= other.offset + other.bytes || other.offset >= offset + bytes);
    REQUIRE(good);
    live.push_back({offset, bytes});
    live_bytes += (bytes + 511) / 512 * 512;
    most_bytes = std::max(most_bytes, live_bytes);
    REQUIRE(extents.end_bytes() <= 3 * most_bytes);
  }
  for (const Extent& extent : live) extents.release(extent.offset, extent.bytes);
  CHECK(extents.end_bytes() == 0);
}

TEST_CASE("ExtentAllocator_TableThatContradictsItself_IsRefused") {
  const std::uint64_t file_bytes = 4096;
  const std::vector<std::vector<BlockEntry>> tables = {
      {entry_at(100, 10)},                        // misaligned
      {entry_at(512, 0)},                         // empty
      {entry_at(4096, 1)},                        // at the end
      {entry_at(3584, 513)},                      // over the end
      {entry_at(~std::uint64_t{0} - 511, 1024)},  // wraps around
      {entry_at(0, 600), entry_at(512, 10)},      // overlap
      {entry_at(1024, 10), entry_at(1024, 10)},   // the same place twice
      {entry_at(512, 10), entry_at(0, 513)},      // overlap, out of order
  };
  for (const auto& table : tables) {
    try {
      ExtentAllocator extents(table, file_bytes, "level");
      FAIL("expected an error");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCorruption);
    }
  }
}

}  // namespace plait::test
