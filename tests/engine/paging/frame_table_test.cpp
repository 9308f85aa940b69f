// Which block is in which frame: the arrows between the states, memory, and the bound.
#include "paging/frame_table.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace plait;
using State = Frame::State;

namespace {

constexpr std::uint64_t kFrameBlockBytes = 4096;

/// `blocks` blocks of one-byte records, without a backend.
void shape(LevelFile& level, std::uint64_t blocks, std::uint32_t attribute = 0, int number = 1) {
  level.geometry = LevelGeometry(SlotShapes(blocks * kFrameBlockBytes >> (2 * (number - 1))),
                                 BaseRelativeLevel(number), 1, kFrameBlockBytes);
  level.table = BlockTable({}, attribute, number, level.geometry.block_count());
}

}  // namespace

TEST_CASE("FrameStates_AllPairs_HaveTheArrowsOfTheDrawing") {
  const std::vector<std::pair<State, std::vector<State>>> arrows{
      {State::kVacant, {State::kClaimed}},
      {State::kClaimed,
       {State::kReading, State::kClean, State::kDirty, State::kDetached, State::kVacant}},
      {State::kReading, {State::kClean, State::kDetached, State::kClaimed}},
      {State::kClean, {State::kDirty, State::kDetached, State::kVacant}},
      {State::kDirty,
       {State::kClean, State::kWriting, State::kWritingHeld, State::kStuck, State::kDetached,
        State::kVacant}},
      {State::kWriting, {State::kClean, State::kDirty}},
      {State::kWritingHeld, {State::kDirty}},
      {State::kStuck, {State::kDetached, State::kVacant}},
      {State::kDetached, {State::kVacant}}};
  REQUIRE(arrows.size() == static_cast<std::size_t>(State::kDetached) + 1);
  for (const auto& [from, targets] : arrows)
    for (int to = 0; to <= static_cast<int>(State::kDetached); ++to) {
      CAPTURE(static_cast<int>(from), to);
      const bool drawn = std::ranges::find(targets, static_cast<State>(to)) != targets.end();
      CHECK(may_become(from, static_cast<State>(to)) == drawn);
    }
}

TEST_CASE("FrameTableClaim_UntilTheBudgetIsUsed_GivesEachBlockAFrame") {
  FrameTable table(3 * kFrameBlockBytes);
  LevelFile level;
  shape(level, 8);
  table.attach(level);
  CHECK(table.find(level, 5) == nullptr);
  std::vector<Frame*> frames;
  for (const std::uint64_t block : {5u, 0u, 7u}) {
    frames.push_back(table.claim(level, block, nullptr));
    REQUIRE(frames.back());
    CHECK(frames.back()->content.state == State::kClaimed);
    CHECK(table.find(level, block) == frames.back());
    CHECK(frames.back()->transfer.memory.size() == kFrameBlockBytes);
  }
  CHECK(table.claim(level, 1, nullptr) == nullptr);
  CHECK(table.pool().used_bytes() == 3 * kFrameBlockBytes);
  std::byte* const memory = frames[1]->content.memory;
  table.vacate(*frames[1]);
  CHECK(table.find(level, 0) == nullptr);
  Frame* const again = table.claim(level, 1, nullptr);
  REQUIRE(again);
  CHECK(again->content.memory == memory);  // frames are recycled
  for (const std::uint64_t block : {5u, 7u, 1u}) table.vacate(*table.find(level, block));
  CHECK(table.pool().used_bytes() == 0);
  table.detach(level);
  CHECK_FALSE(table.is_attached(level));
}

TEST_CASE("FrameTableDetachBlock_FrameThatIsStillHeld_KeepsItsMemoryBesideTheBlocksNextFrame") {
  FrameTable table(2 * kFrameBlockBytes);
  LevelFile level;
  shape(level, 4);
  table.attach(level);
  Frame* const first = table.claim(level, 2, nullptr);
  table.detach_block(*first);
  CHECK(table.find(level, 2) == nullptr);
  Frame* const second = table.claim(level, 2, nullptr);
  REQUIRE(second);
  CHECK(second->content.memory != first->content.memory);
  table.vacate(*first);
  CHECK(table.find(level, 2) == second);
  table.vacate(*second);
  table.detach(level);
}

TEST_CASE("FrameTableClaim_WithAnAddress_CountsItAndTakesNoMemory") {
  FrameTable table(kFrameBlockBytes);
  LevelFile level;
  shape(level, 4);
  table.attach(level);
  std::vector<std::byte> memory(4 * kFrameBlockBytes);
  Frame* const frame = table.claim(level, 1, memory.data());
  REQUIRE(frame);
  CHECK(frame->content.memory == memory.data());
  CHECK(table.claim(level, 2, memory.data() + kFrameBlockBytes) == nullptr);
  table.vacate(*frame);
  table.detach(level);
}

TEST_CASE("FrameTableAttach_ManyBlocks_MakesNoMoreFramesThanTheBudgetCanHold") {
  FrameTable table(16 * kFrameBlockBytes);
  LevelFile large, small;
  shape(large, 1000);
  shape(small, 3, 1, 2);
  table.attach(large);
  table.attach(small);
  CHECK(table.frames().size() == 16);
  CHECK(table.level(1, 2) == &small);
  CHECK(table.level(1, 3) == nullptr);
  table.detach(small);
  CHECK(table.level(1, 2) == nullptr);
  table.attach(small);  // takes the place that came free
  CHECK(small.pager_slot == 1);
  table.detach(small);
  table.detach(large);
}

TEST_CASE("FrameTableClaim_BlockDetachedAgainAndAgain_EndsWithoutAFrameAndLosesNoMemory") {
  FrameTable table(16 * kFrameBlockBytes);
  LevelFile level;
  shape(level, 1);
  table.attach(level);
  const bool addressed = GENERATE(false, true);
  std::vector<std::byte> memory(kFrameBlockBytes);
  std::vector<Frame*> frames;
  while (Frame* const frame = table.claim(level, 0, addressed ? memory.data() : nullptr)) {
    frames.push_back(frame);
    table.detach_block(*frame);
  }
  CHECK(frames.size() == 2);  // that of the block, and one from which it was detached
  CHECK(table.find(level, 0) == nullptr);
  CHECK(table.pool().used_bytes() == 2 * kFrameBlockBytes);
  for (Frame* const frame : frames) table.vacate(*frame);
  CHECK(table.pool().used_bytes() == 0);
  table.detach(level);
}
