// Who waits in the pager is told when it need not wait any more: for a frame, for a block that
// another call brings in, and for the outcome of a write.
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "engine/paging/held_level.h"
#include "support/error_of.h"
#include "support/eventually.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Where the system chooses which of two threads is the first to be told of a change.
constexpr int kRounds = 20;

bool holds_own_value(const PinnedBlock& pinned, std::uint64_t block) {
  return pinned.bytes()[9] == HeldLevel::value(block);
}

/// While a call of pin_many looks for room for its second block, `beside` runs in another thread.
struct CallBesideAnother {
  /// Overwrites blocks 0, 1, ... in a pager with two frames. One of them has a clean block, whose
  /// eviction begins `beside`.
  void overwrite(std::uint64_t count, std::span<PinnedBlock> pinned) {
    level.pin(7, Access::kRead);
    std::vector<BlockRequest> requests;
    for (std::uint64_t block = 0; block < count; ++block)
      requests.emplace_back(level.file, block, Access::kOverwrite);
    at_eviction = [this] { std::async(std::launch::async, beside).get(); };
    level.session.pin_many(requests, pinned);
  }
  void fill_and_flush(std::span<PinnedBlock> pinned, int byte) {
    for (const PinnedBlock& each : pinned)
      std::memset(each.bytes().data(), byte, each.bytes().size());
    PinnedBlock::release_all(pinned);
    pager.flush();
  }
  bool holds(std::uint64_t block, int byte) {
    return level.pin(block, Access::kRead).bytes()[9] == static_cast<std::byte>(byte);
  }

  std::function<void()> beside, at_eviction;
  Pager pager{2 * kBlockBytes, 0, {.call = [this](const StoreEvent&) {
                if (at_eviction) std::exchange(at_eviction, nullptr)();
              }}};
  HeldLevel level{pager, 8};
};

}  // namespace

TEST_CASE("PagerPin_FrameOfACallThatIsAboutToEnd_IsWaitedFor") {
  for (int round = 0; round < kRounds; ++round) {
    Pager pager(kBlockBytes, 1);
    HeldLevel level(pager, 8);
    Session other = pager.open_session();
    level.backend->hold();
    auto first = std::async(std::launch::async,
                            [&] { return holds_own_value(other.pin(level.file, 0), 0); });
    level.backend->wait_until_started(1, 0);
    auto second = std::async(std::launch::async,
                             [&] { return holds_own_value(level.pin(1, Access::kRead), 1); });
    CHECK(eventually(other_threads_sleep));
    level.backend->let_all_go();
    CHECK(first.get());
    CHECK(second.get());
  }
}

TEST_CASE("PagerPin_FrameThatACallOfTheSameSessionKeeps_IsRefusedAsTheCallEnds") {
  for (int round = 0; round < kRounds; ++round) {
    Pager pager(kBlockBytes, 1);
    HeldLevel level(pager, 8);
    level.backend->hold();
    std::promise<void> refused;
    auto first = std::async(std::launch::async, [&] {
      const PinnedBlock kept = level.pin(0, Access::kRead);
      refused.get_future().wait();
    });
    level.backend->wait_until_started(1, 0);
    auto second = std::async(std::launch::async,
                             [&] { return code_of([&] { level.pin(1, Access::kRead); }); });
    CHECK(eventually(other_threads_sleep));
    level.backend->let_all_go();
    CHECK(second.get() == ErrorCode::kBudget);
    refused.set_value();
    first.get();
  }
}

TEST_CASE("PinMany_TwoCallsThatOverwriteTheSameBlocks_DoNotWaitForEachOther") {
  CallBesideAnother calls;
  std::array<PinnedBlock, 2> first, second;
  calls.beside = [&] {
    const std::array requests{BlockRequest(calls.level.file, 1, Access::kOverwrite),
                              BlockRequest(calls.level.file, 0, Access::kOverwrite)};
    calls.level.session.pin_many(requests, second);
  };
  calls.overwrite(2, first);
  CHECK(first[0].bytes().data() == second[1].bytes().data());
  CHECK(first[1].bytes().data() == second[0].bytes().data());
  PinnedBlock::release_all(second);
  calls.fill_and_flush(first, 77);
  CHECK(calls.holds(0, 77));
  CHECK(calls.holds(1, 77));
}

TEST_CASE("PinMany_CallThatGivesUpABlockThatAnotherOneOverwrites_LeavesItToTheOther") {
  CallBesideAnother calls;
  std::array<PinnedBlock, 3> first;
  std::array<PinnedBlock, 2> second;
  calls.beside = [&] {
    const std::array requests{BlockRequest(calls.level.file, 1, Access::kOverwrite),
                              BlockRequest(calls.level.file, 0, Access::kOverwrite)};
    calls.level.session.pin_many(requests, second);
  };
  CHECK(code_of([&] { calls.overwrite(3, first); }) == ErrorCode::kBudget);
  calls.fill_and_flush(second, 77);
  CHECK(calls.holds(0, 77));
  CHECK(calls.holds(1, 77));
}

TEST_CASE("SessionEnd_WhileAnotherWaitsForItsPin_RefusesTheOther") {
  Pager pager(kBlockBytes, 1);
  HeldLevel level(pager, 8);
  std::optional<Session> holding = pager.open_session();
  const PinnedBlock left = holding->pin(level.file, 0);
  auto waiting =
      std::async(std::launch::async, [&] { return code_of([&] { level.pin(1, Access::kRead); }); });
  CHECK(is_waiting(waiting));
  holding.reset();
  CHECK(waiting.get() == ErrorCode::kBudget);
}

TEST_CASE("PagerPin_BlockNeverWrittenThatAnotherCallBringsIn_IsWaitedFor") {
  for (int round = 0; round < kRounds; ++round) {
    Pager pager(4 * kBlockBytes, 1);
    HeldLevel level(pager, 8);
    level.file.table.entries()[3] = {};
    level.backend->hold();
    auto both = std::async(std::launch::async, [&] {
      const std::array requests{BlockRequest(level.file, 2), BlockRequest(level.file, 3)};
      std::array<PinnedBlock, 2> pinned;
      level.session.pin_many(requests, pinned);
      return holds_own_value(pinned[0], 2) && pinned[1].bytes()[9] == std::byte{0};
    });
    level.backend->wait_until_started(1, 0);
    auto zeros = std::async(std::launch::async,
                            [&] { return level.pin(3, Access::kRead).bytes()[9] == std::byte{0}; });
    CHECK(eventually(other_threads_sleep));
    level.backend->let_all_go();
    CHECK(both.get());
    CHECK(zeros.get());
  }
}

TEST_CASE("PagerPin_BlockThatAnotherCallOverwrites_IsWaitedForUntilThatCallEnds") {
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  Session other = pager.open_session();
  level.backend->hold();
  std::promise<void> may_unpin;
  auto both = std::async(std::launch::async, [&] {
    const std::array requests{BlockRequest(level.file, 3, Access::kOverwrite),
                              BlockRequest(level.file, 2)};
    std::array<PinnedBlock, 2> pinned;
    level.session.pin_many(requests, pinned);
    may_unpin.get_future().wait();
  });
  level.backend->wait_until_started(1, 0);
  auto read = std::async(std::launch::async, [&] { other.pin(level.file, 3); });
  CHECK(is_waiting(read));
  level.backend->let_all_go();
  CHECK(read.wait_for(std::chrono::minutes(5)) == std::future_status::ready);
  may_unpin.set_value();
  both.get();
  read.get();
}

TEST_CASE("PagerPin_BlockOfACallThatFindsNoRoom_IsBroughtInByWhoWaitsForIt") {
  Pager pager(3 * kBlockBytes, 0);
  HeldLevel level(pager, 8);
  Session holding = pager.open_session();
  PinnedBlock pinned = holding.pin(level.file, 0);
  level.put(1, 99);
  level.backend->hold();
  auto three = std::async(std::launch::async, [&] {
    const std::array requests{BlockRequest(level.file, 2), BlockRequest(level.file, 3),
                              BlockRequest(level.file, 4)};
    std::array<PinnedBlock, 3> blocks;
    level.session.pin_many(requests, blocks);
    return holds_own_value(blocks[0], 2) && holds_own_value(blocks[2], 4);
  });
  // It has a frame for block 2, and writes block 1 to have another one.
  level.backend->wait_until_started(1, 1);
  auto one = std::async(std::launch::async,
                        [&] { return holds_own_value(level.pin(2, Access::kRead), 2); });
  CHECK(is_waiting(one));
  level.backend->let_all_go();
  CHECK(one.get());
  CHECK(is_waiting(three));
  pinned.release();
  CHECK(three.get());
}

TEST_CASE("PagerPin_ForWritingWhileAFlushWritesTheBlock_WaitsForTheWrite") {
  Pager pager(4 * kBlockBytes, 0);
  HeldLevel level(pager, 8);
  level.put(0, 42);
  level.backend->hold();
  auto both = std::async(std::launch::async, [&] {
    const std::array requests{BlockRequest(level.file, 0, Access::kUpdate),
                              BlockRequest(level.file, 1)};
    std::array<PinnedBlock, 2> pinned;
    level.session.pin_many(requests, pinned);
    std::memset(pinned[0].bytes().data(), 43, kBlockBytes);
  });
  level.backend->wait_until_started(1, 0);  // it has block 0 and reads block 1
  auto flushed = std::async(std::launch::async, [&] { pager.flush(); });
  level.backend->wait_until_started(1, 1);
  level.backend->let_go(Direction::kRead, 1);
  CHECK(is_waiting(both));
  level.backend->let_all_go();
  both.get();
  flushed.get();
  pager.flush();
  pager.discard();
  CHECK(level.pin(0, Access::kRead).bytes()[5] == std::byte{43});
}

TEST_CASE("PagerPin_ForWritingWhenAWriteHasFailed_IsRefusedAndNothingIsWritten") {
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  PinnedBlock held = level.pin(1, Access::kUpdate);
  level.pin(2, Access::kRead);
  level.backend->hold();
  level.put(0, 42);
  auto waiting = std::async(std::launch::async,
                            [&] { return code_of([&] { level.pin(3, Access::kUpdate); }); });
  level.backend->wait_until_started(3, 1);
  level.backend->let_go(Direction::kWrite, 0, true);
  level.backend->let_all_go();
  CHECK(waiting.get() == ErrorCode::kNoSpace);
  for (const std::uint64_t resident : {0u, 1u, 2u, 3u})
    CHECK(code_of([&] { level.pin(resident, Access::kUpdate); }) == ErrorCode::kBadState);
  std::memset(held.bytes().data(), 43, kBlockBytes);
  held.release();
  // By the thread that would have written block 1 before.
  CHECK(level.session.prefetch(level.file, 5));
  level.backend->wait_until_started(4, 1);
  CHECK(level.backend->started_writes == 1);
  CHECK(code_of([&] { pager.flush(); }) == ErrorCode::kBadState);
  // It is the only copy, as that of block 0 is.
  for (std::uint64_t block = 2; block < 8; ++block)
    CHECK(holds_own_value(level.pin(block, Access::kRead), block));
  CHECK(level.pin(0, Access::kRead).bytes()[0] == std::byte{42});
  CHECK(level.pin(1, Access::kRead).bytes()[0] == std::byte{43});
  pager.discard();
}
