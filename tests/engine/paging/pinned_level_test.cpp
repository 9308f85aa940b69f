#include "plait/detail/pinned_level.h"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

#include "fake_level.h"
#include "paging/level_cursor.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Edges of a block of TestLevel at level 2: slots of 4 records.
constexpr EdgeId kBlockEdges = 1024;

std::byte first_byte(const PinnedLevel& level, EdgeId edge) { return level.slot(edge).bytes[0]; }

void put_numbers_on_disk(const TestLevel& level) {
  for (std::uint64_t block = 0; block < level.file.geometry.block_count(); ++block)
    level.put_on_disk(block, static_cast<unsigned char>(block + 1));
  level.backend->reads = 0;
}

void pin(Session& session, PinnedLevel& level, const std::vector<EdgeId>& edges) {
  level.begin_step();
  for (const EdgeId edge : edges) level.need(edge);
  PinnedLevel::pin_needed(session, std::span(&level, 1));
}

}  // namespace

TEST_CASE("PinnedLevel_NeededEdges_HaveTheirSlotsAndBlocksAreReadOnce") {
  Pager pager(8 * kBlockBytes, 0);
  TestLevel file(pager, 2, 4 * kBlockEdges);
  put_numbers_on_disk(file);
  Session session = pager.open_session();
  PinnedLevel level(std::as_const(file.file));
  pin(session, level, {5, 3 * kBlockEdges, 6, 3 * kBlockEdges + 1});
  CHECK(file.backend->reads == 2);
  CHECK(level.needed_bytes() == 2 * kBlockBytes);
  CHECK(level.pinned_bytes() == 2 * kBlockBytes);
  for (EdgeId edge = 0; edge < kBlockEdges; ++edge) {
    REQUIRE(level.is_pinned(edge));
    REQUIRE(first_byte(level, edge) == std::byte{1});
    REQUIRE(level.slot(edge).bytes.size() == 4);
    REQUIRE(level.slot(edge).bytes.data() == level.slot(0).bytes.data() + 4 * edge);
  }
  CHECK(first_byte(level, 4 * kBlockEdges - 1) == std::byte{4});
  CHECK_FALSE(level.is_pinned(kBlockEdges));
  pin(session, level, {7, kBlockEdges});
  CHECK(file.backend->reads == 3);
  CHECK(first_byte(level, kBlockEdges) == std::byte{2});
}

TEST_CASE("PinnedLevel_Release_EndsThePinsThatAreOldest") {
  Pager pager(8 * kBlockBytes, 0);
  TestLevel file(pager, 2, 4 * kBlockEdges);
  Session session = pager.open_session();
  PinnedLevel level(std::as_const(file.file));
  const auto block = [](EdgeId number) { return number * kBlockEdges; };
  pin(session, level, {block(0)});
  pin(session, level, {block(1)});
  pin(session, level, {block(2)});
  pin(session, level, {block(0)});  // needed again: now block 1 is the oldest
  CHECK(level.has_rest());
  level.release_oldest();
  CHECK_FALSE(level.is_pinned(block(1)));
  CHECK(level.pinned_bytes() == 2 * kBlockBytes);
  level.begin_step();
  level.need(block(2));
  level.need(block(3));
  CHECK(level.missing_bytes() == kBlockBytes);
  level.release_rest();
  CHECK_FALSE(level.is_pinned(block(0)));
  CHECK(level.is_pinned(block(2)));
  PinnedLevel::pin_needed(session, std::span(&level, 1));
  CHECK_FALSE(level.has_rest());
  level.release(block(2) + 1);
  CHECK_FALSE(level.is_pinned(block(2)));
  CHECK(level.is_pinned(block(3)));
}

TEST_CASE("PinnedLevel_SeveralLevels_ArePinnedTogetherOrNotAtAll") {
  Pager pager(4 * kBlockBytes, 0);
  TestLevel coarse(pager, 2, 4 * kBlockEdges), fine(pager, 3, 4 * kBlockEdges);
  Session session = pager.open_session();
  std::vector<PinnedLevel> levels;
  levels.emplace_back(std::as_const(coarse.file));
  levels.emplace_back(std::as_const(fine.file));
  const auto begin = [&] {
    for (PinnedLevel& level : levels) level.begin_step();
  };
  begin();
  levels[1].need(0);
  levels[1].need(kBlockEdges - 1);
  levels[0].need_edges_of(levels[1]);
  CHECK(levels[0].needed_bytes() == kBlockBytes);
  CHECK(levels[1].needed_bytes() == 2 * kBlockBytes);
  PinnedLevel::pin_needed(session, levels);
  CHECK(levels[0].is_pinned(0));
  CHECK(levels[1].is_pinned(kBlockEdges - 1));

  begin();
  levels[0].need(kBlockEdges);
  levels[1].need(kBlockEdges);
  CHECK_THROWS_AS(PinnedLevel::pin_needed(session, levels), Error);  // five blocks in four frames
  CHECK_FALSE(levels[0].is_pinned(kBlockEdges));
  CHECK_FALSE(levels[1].is_pinned(kBlockEdges));
  CHECK(levels[1].is_pinned(0));
  for (PinnedLevel& level : levels) level.release_rest();
  PinnedLevel::pin_needed(session, levels);
  CHECK(levels[0].is_pinned(kBlockEdges));

  // A block of the coarser level has the edges of four of the finer one.
  begin();
  levels[0].need(0);
  levels[1].need_edges_of(levels[0]);
  CHECK(levels[1].needed_bytes() == 4 * kBlockBytes);
}

TEST_CASE("PinnedLevelNeedEdgesOf_BlocksOfOneSlot_AreNeededOneByOne") {
  Pager pager(4 * kBlockBytes, 0);
  TestLevel one(pager, 7, 8), other(pager, 7, 8);
  PinnedLevel asked(std::as_const(one.file)), needed(std::as_const(other.file));
  REQUIRE(asked.geometry().block_count() == 8);
  asked.begin_step();
  needed.begin_step();
  for (const EdgeId edge : {2u, 7u}) asked.need(edge);
  needed.need_edges_of(asked);
  CHECK(needed.needed_bytes() == 2 * kBlockBytes);
}

TEST_CASE("PinnedLevel_Overwrites_ReadsOnlyWhatItHasWritten") {
  Pager pager(2 * kBlockBytes, 0);
  TestLevel file(pager, 2, 4 * kBlockEdges);
  put_numbers_on_disk(file);
  Session session = pager.open_session();
  PinnedLevel level(file.file, Access::kOverwrite);
  for (EdgeId block = 0; block < 4; ++block) {
    pin(session, level, {block * kBlockEdges});
    level.slot(block * kBlockEdges).bytes[0] = static_cast<std::byte>(50 + block);
    level.release_block(block);
  }
  CHECK(file.backend->reads == 0);
  pin(session, level, {0});
  CHECK(first_byte(level, 0) == std::byte{50});
  CHECK(file.backend->reads == 1);
}

TEST_CASE("PinnedLevel_DestroyedByAnException_AbandonsWhatItWrote") {
  Pager pager(8 * kBlockBytes, 0);
  TestLevel file(pager, 2, 2 * kBlockEdges);
  put_numbers_on_disk(file);
  Session session = pager.open_session();
  for (const bool thrown : {true, false}) {
    try {
      PinnedLevel level(file.file, Access::kUpdate);
      pin(session, level, {0});
      level.slot(0).bytes[0] = std::byte{99};
      if (thrown) throw std::runtime_error("in the middle");
    } catch (const std::runtime_error&) {
    }
    CHECK(file.file.left_unfinished == thrown);
    file.file.left_unfinished = false;
    PinnedLevel level(std::as_const(file.file));
    pin(session, level, {0});
    CHECK(first_byte(level, 0) == (thrown ? std::byte{1} : std::byte{99}));
  }
  try {
    PinnedLevel level(std::as_const(file.file));
    pin(session, level, {0});
    throw std::runtime_error("while reading");
  } catch (const std::runtime_error&) {
  }
  CHECK_FALSE(file.file.left_unfinished);
}

TEST_CASE("LevelCursor_AllEdges_ReadsAndWritesEachBlockOnce") {
  for (const int io_threads : {0, 1}) {
    Pager pager(6 * kBlockBytes, io_threads);
    TestLevel from(pager, 2, 20 * kBlockEdges), to(pager, 2, 20 * kBlockEdges);
    put_numbers_on_disk(from);
    {
      LevelCursor source(pager.open_session(), std::as_const(from.file));
      LevelCursor target(pager.open_session(), to.file, Access::kOverwrite);
      bool right = true;
      for (EdgeId edge = 0; edge < 20 * kBlockEdges; ++edge) {
        const std::span<std::byte> slot = source.slot(edge).bytes;
        right &= slot.size() == 4 && slot[3] == static_cast<std::byte>(edge / kBlockEdges + 1);
        std::memcpy(target.slot(edge).bytes.data(), slot.data(), slot.size());
      }
      CHECK(right);
    }
    pager.flush();
    CHECK(from.backend->reads == 20);
    CHECK(to.backend->reads == 0);
    CHECK(to.backend->writes == 20);
    for (std::uint64_t block = 0; block < 20; ++block)
      CHECK(*to.backend->address_of(block) == static_cast<std::byte>(block + 1));
  }
}
