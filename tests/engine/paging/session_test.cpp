// Several sessions on one pager: whose frames go first, and who waits for whom
// (plait/extend/session.h).
#include "plait/extend/session.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <latch>
#include <thread>

#include "engine/paging/fake_level.h"
#include "plait/error.h"
#include "plait/extend/pager.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Blocks of one-byte records, block b filled with b + 1.
struct FilledLevel : TestLevel {
  FilledLevel(Pager& its_pager, std::uint64_t blocks)
      : TestLevel(its_pager, 1, blocks * kBlockBytes) {
    for (std::uint64_t block = 0; block < blocks; ++block)
      put_on_disk(block, static_cast<unsigned char>(block + 1));
    backend->writes = 0;
  }
  const LevelFile& read_only() const { return file; }
};

bool holds_own_number(const PinnedBlock& pinned, std::uint64_t block) {
  return holds(pinned, static_cast<unsigned char>(block + 1));
}

template <class Call>
std::string budget_error(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    REQUIRE(error.code() == ErrorCode::kBudget);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("SessionPin_SweepBesideAWalkWithinItsShare_LeavesTheWalksBlocks") {
  const auto policy = GENERATE(EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock);
  Pager pager(8 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 64);
  Session walk = pager.open_session({.policy = policy, .share_bytes = 4 * kBlockBytes});
  Session sweep = pager.open_session();
  for (std::uint64_t block = 0; block < 4; ++block) walk.pin(level.read_only(), block);
  for (std::uint64_t block = 8; block < 64; ++block) {
    CHECK(holds_own_number(sweep.pin(level.read_only(), block), block));
    sweep.prefetch(level.read_only(), block + 1 < 64 ? block + 1 : block);
  }
  const std::uint64_t read = walk.statistics().blocks_read;
  for (std::uint64_t block = 0; block < 4; ++block)
    CHECK(holds_own_number(walk.pin(level.read_only(), block), block));
  CHECK(walk.statistics().blocks_read == read);
  CHECK(walk.statistics().blocks_evicted == 0);
  CHECK(sweep.statistics().blocks_evicted >= 50);
}

TEST_CASE("SessionPin_WhileNobodyElseNeedsIt_TakesMoreThanItsShare") {
  Pager pager(8 * kBlockBytes, 0);
  FilledLevel level(pager, 16);
  Session walk = pager.open_session({.share_bytes = 2 * kBlockBytes});
  for (std::uint64_t block = 0; block < 8; ++block) walk.pin(level.read_only(), block);
  CHECK(walk.statistics().blocks_evicted == 0);
  CHECK(walk.statistics().peak_frame_bytes == 8 * kBlockBytes);
  // Then it is the one that is furthest over its share.
  Session other = pager.open_session({.share_bytes = 6 * kBlockBytes});
  for (std::uint64_t block = 8; block < 14; ++block) other.pin(level.read_only(), block);
  CHECK(walk.statistics().blocks_evicted == 6);
  CHECK(other.statistics().blocks_evicted == 0);
}

TEST_CASE("SessionEnd_WhatItLeft_IsTakenBeforeWhatOthersUse") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 16);
  Session staying = pager.open_session({.share_bytes = kBlockBytes});
  staying.pin(level.read_only(), 0);
  staying.pin(level.read_only(), 1);
  {
    Session ending = pager.open_session();
    ending.pin(level.read_only(), 2);
    ending.pin(level.read_only(), 3);
  }
  Session next = pager.open_session();
  next.pin(level.read_only(), 4);
  next.pin(level.read_only(), 5);
  const int reads = level.backend->reads;
  for (const std::uint64_t block : {0u, 1u, 4u, 5u}) next.pin(level.read_only(), block);
  CHECK(level.backend->reads == reads);
}

TEST_CASE("SessionPin_BlockOfAnotherSession_BelongsToWhoUsedItLast") {
  Pager pager(4 * kBlockBytes, 0);
  FilledLevel level(pager, 16);
  Session first = pager.open_session({.share_bytes = 2 * kBlockBytes});
  Session second = pager.open_session({.share_bytes = 2 * kBlockBytes});
  for (std::uint64_t block = 0; block < 4; ++block) first.pin(level.read_only(), block);
  for (std::uint64_t block = 0; block < 4; ++block) second.pin(level.read_only(), block);
  CHECK(level.backend->reads == 4);
  first.pin(level.read_only(), 9);  // which is not over its share any more
  CHECK(first.statistics().blocks_evicted == 0);
  CHECK(second.statistics().blocks_evicted == 1);
}

TEST_CASE("SessionEnd_PinsThatAreLeft_StayValidUntilTheyEnd") {
  Pager pager(2 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 8);
  PinnedBlock left = pager.open_session().pin(level.read_only(), 3);
  Session session = pager.open_session();
  for (std::uint64_t block = 4; block < 8; ++block) session.pin(level.read_only(), block);
  CHECK(holds_own_number(left, 3));
  left.release();
  const PinnedBlock one = session.pin(level.read_only(), 0),
                    two = session.pin(level.file, 1, Access::kUpdate);
  CHECK(holds_own_number(one, 0));
  CHECK(holds_own_number(two, 1));
}

TEST_CASE("SessionPinMany_SomeThatCannotBeHad_PinsNone") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 16);
  Session session = pager.open_session();
  std::vector<BlockRequest> requests;
  for (std::uint64_t block = 0; block < 4; ++block) requests.emplace_back(level.read_only(), block);
  requests.emplace_back(level.read_only(), 2);  // twice
  std::vector<PinnedBlock> pinned(requests.size());
  session.pin_many(requests, pinned);
  for (std::size_t i = 0; i < requests.size(); ++i)
    CHECK(holds_own_number(pinned[i], requests[i].block()));
  CHECK(level.backend->reads == 4);

  requests.emplace_back(level.read_only(), 9);
  pinned.resize(requests.size());
  CHECK(budget_error([&] { session.pin_many(requests, pinned); }) ==
        "page in fake: at least 20480 bytes of frames are needed and 16384 of 16384 are available; "
        "raise the budget to 20480 bytes");
  for (const PinnedBlock& none : pinned) CHECK_FALSE(none);

  level.backend->address_of(5)[100] ^= std::byte{1};
  const std::vector<BlockRequest> damaged{
      {level.read_only(), 4}, {level.read_only(), 5}, {level.file, 6, Access::kOverwrite}};
  pinned.resize(3);
  CHECK_THROWS_AS(session.pin_many(damaged, pinned), Error);
  for (const PinnedBlock& none : pinned) CHECK_FALSE(none);
  // Nothing is held, and nothing that was to be written exists.
  pager.flush();
  CHECK(level.backend->writes == 0);
  CHECK(level.file.is_finished());
  CHECK(holds_own_number(session.pin(level.read_only(), 6), 6));
  pinned.resize(4);
  session.pin_many(std::span(requests).first(4), pinned);
}

TEST_CASE("SessionPin_AllFramesPinnedByAnotherSession_WaitsUntilOneIsFree") {
  Pager pager(2 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 8);
  Session holding = pager.open_session(), asking = pager.open_session();
  PinnedBlock one = holding.pin(level.read_only(), 0);
  const PinnedBlock two = holding.pin(level.read_only(), 1);
  auto waiting = std::async(std::launch::async,
                            [&] { return holds_own_number(asking.pin(level.read_only(), 2), 2); });
  CHECK(is_waiting(waiting));
  one.release();
  CHECK(waiting.get());
}

// Whoever asks second is refused, and lets go of what it holds.
TEST_CASE("SessionPin_TwoThatHoldHalfAndAskForMore_OneGetsBudgetAndTheOtherGoesOn") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 8);
  std::latch both_hold_half(2);
  const auto ask = [&](std::uint64_t block) {
    Session session = pager.open_session();
    const PinnedBlock one = session.pin(level.read_only(), block),
                      two = session.pin(level.read_only(), block + 1);
    both_hold_half.arrive_and_wait();
    return budget_error([&] {
      if (!holds_own_number(session.pin(level.read_only(), block + 4), block + 4))
        throw std::logic_error("it holds other bytes");
    });
  };
  auto first = std::async(std::launch::async, ask, 0),
       second = std::async(std::launch::async, ask, 2);
  const std::string of_first = first.get(), of_second = second.get();
  CHECK(of_first.empty() != of_second.empty());
  CHECK(of_first + of_second ==
        "page in fake: at least 4096 bytes of frames are needed and 0 of 16384 are available; the "
        "others are pinned: end pins or views, or raise the budget");
}

TEST_CASE("SessionPin_AllFramesPinnedByTheSameThread_IsRefusedInWhateverSession") {
  Pager pager(2 * kBlockBytes, 1);
  FilledLevel level(pager, 8);
  Session first = pager.open_session(), second = pager.open_session();
  const PinnedBlock one = first.pin(level.read_only(), 0), two = first.pin(level.read_only(), 1);
  CHECK_FALSE(budget_error([&] { first.pin(level.read_only(), 2); }).empty());
  CHECK_FALSE(budget_error([&] { second.pin(level.read_only(), 2); }).empty());
}

TEST_CASE("SessionPin_WhoWaitedForAPinThatEndsInVain_IsRefusedThen") {
  Pager pager(3 * kBlockBytes, 1);
  FilledLevel level(pager, 8);
  Session first = pager.open_session(), second = pager.open_session(), third = pager.open_session();
  PinnedBlock held = second.pin(level.read_only(), 2);
  auto waiting = std::async(std::launch::async, [&] {
    const PinnedBlock one = first.pin(level.read_only(), 0), two = first.pin(level.read_only(), 1);
    const std::vector<BlockRequest> more{{level.read_only(), 4}, {level.read_only(), 5}};
    std::vector<PinnedBlock> pinned(2);
    return budget_error([&] { first.pin_many(more, pinned); });
  });
  CHECK(is_waiting(waiting));
  held.release();
  CHECK_FALSE(waiting.get().empty());
}

TEST_CASE("SessionStatistics_OfTheOnlySession_AreThoseOfThePager") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  FilledLevel level(pager, 16);
  Session session = pager.open_session();
  session.pin(level.read_only(), 15);  // nobody prefetched it, so this is a wait for certain
  for (std::uint64_t block = 0; block < 12; ++block) {
    if (block % 3 == 0)
      fill(session.pin(level.file, block, Access::kOverwrite), 7);
    else
      session.pin(level.read_only(), block);
    // Each is pinned in the next turn, so no read is on its way when the figures are compared.
    if (block + 1 < 12) session.prefetch(level.read_only(), block + 1);
  }
  pager.flush();  // its waits are nobody's
  const PagingStatistics own = session.statistics(), all = pager.statistics();
  CHECK(own.blocks_read > 0);
  CHECK(own.blocks_evicted > 0);
  CHECK(own.blocks_read == all.blocks_read);
  CHECK(own.blocks_written == all.blocks_written);
  CHECK(own.blocks_evicted == all.blocks_evicted);
  CHECK(own.blocks_prefetched == all.blocks_prefetched);
  CHECK(own.bytes_read == all.bytes_read);
  CHECK(own.bytes_written == all.bytes_written);
  CHECK(own.peak_frame_bytes == all.peak_frame_bytes);
  CHECK(own.read_waits > 0);
  CHECK(own.read_waits == all.read_waits);
  CHECK(own.read_wait_ns == all.read_wait_ns);
  CHECK(own.write_waits <= all.write_waits);
  CHECK(all.blocks_read == static_cast<std::uint64_t>(level.backend->reads));
  CHECK(all.blocks_written == static_cast<std::uint64_t>(level.backend->writes));
}

TEST_CASE("SessionPin_OnlyWrites_LargeBudget_WrittenBlocksLeaveForNewOnes") {
  constexpr std::uint64_t kKept = (std::uint64_t{32} << 20) / kBlockBytes, kMore = 64;
  const bool only_writes = GENERATE(true, false), in_page_cache = GENERATE(true, false);
  Pager pager(4 * kKept * kBlockBytes, GENERATE(0, 1));
  TestLevel level(pager, 1, (kKept + kMore) * kBlockBytes,
                  {.durable = true, .in_page_cache = in_page_cache});
  Session session = pager.open_session({.only_writes = only_writes});
  const auto fill = [&](std::uint64_t block) {
    const PinnedBlock pinned = session.pin(level.file, block, Access::kOverwrite);
    std::ranges::fill(pinned.bytes(), static_cast<std::byte>(block % 251));
  };
  for (std::uint64_t block = 0; block < kKept; ++block) fill(block);
  pager.flush();
  const std::uint64_t before = session.statistics().blocks_evicted;
  for (std::uint64_t block = kKept; block < kKept + kMore; ++block) fill(block);
  const bool leave = only_writes && in_page_cache;
  CHECK(session.statistics().blocks_evicted - before == (leave ? kMore : 0));
  CHECK(session.statistics().peak_frame_bytes == (kKept + (leave ? 0 : kMore)) * kBlockBytes);
  pager.flush();
  const LevelFile& reads = level.file;
  for (std::uint64_t block = 0; block < kKept + kMore; ++block)
    if (!holds(session.pin(reads, block), static_cast<unsigned char>(block % 251)))
      FAIL("block " << block);
}
