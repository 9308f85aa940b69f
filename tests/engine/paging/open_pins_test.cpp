// Pins of blocks that are in memory, which take no lock (paging/pin_count.h): beside the lock's
// holder, beside eviction, and beside threads that wait for a frame.
#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <future>
#include <latch>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "engine/paging/fake_level.h"
#include "paging/pin_count.h"
#include "paging/session_callers.h"
#include "plait/error.h"
#include "plait/extend/pager.h"
#include "support/sanitized.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Blocks of one-byte records, block b filled with b + 1.
struct NumberedLevel : TestLevel {
  NumberedLevel(Pager& its_pager, std::uint64_t blocks, const BackendTraits& traits = kFramed)
      : TestLevel(its_pager, 1, blocks * kBlockBytes, traits) {
    for (std::uint64_t block = 0; block < blocks; ++block)
      put_on_disk(block, static_cast<unsigned char>(block + 1));
  }
  const LevelFile& read_only() const { return file; }
};

bool shows_its_number(const PinnedBlock& pinned, std::uint64_t block) {
  return holds(pinned, static_cast<unsigned char>(block + 1));
}

bool try_add(PinCount& pins) {
  return pins.try_add([] { return true; });
}

/// Whether as many blocks as the budget has frames can be pinned at once: no pin was lost, and no
/// frame is one that nobody would ever evict.
bool all_frames_can_be_had(Pager& pager, const LevelFile& level, std::uint64_t first_block) {
  const std::uint64_t frames = pager.budget_bytes() / kBlockBytes;
  std::vector<BlockRequest> requests;
  for (std::uint64_t i = 0; i < frames; ++i) requests.emplace_back(level, first_block + i);
  std::vector<PinnedBlock> pinned(frames);
  Session session = pager.open_session();
  session.pin_many(requests, pinned);
  return std::ranges::all_of(pinned, [](const PinnedBlock& pin) { return bool{pin}; });
}

/// Several threads that pin and check blocks at random in a pager with few frames. The first blocks
/// are used most.
class Crowd {
 public:
  Crowd(Pager& pager, const LevelFile& level, std::uint64_t blocks)
      : level_(level), blocks_(blocks) {
    for (std::size_t i = 0; i < sessions_.size(); ++i)
      sessions_[i] = pager.open_session(
          {.policy = i == 0 ? EvictionPolicy::kClock : EvictionPolicy::kLayoutOrder});
  }

  void run(unsigned threads, int steps) {
    std::vector<std::thread> running;
    for (unsigned number = 0; number < threads; ++number)
      running.emplace_back([this, number, steps] { work(number, steps); });
    for (std::thread& thread : running) thread.join();
    handed_over_.clear();
  }

  /// Blocks with bytes that they should not have.
  std::atomic<int> wrong = 0;

 private:
  void work(unsigned number, int steps) noexcept {
    std::mt19937 random(number + 1);
    // Most threads share the first session.
    Session& session = sessions_[number % 4 == 3 ? 1 : 0];
    for (int step = 0; step < steps; ++step) {
      const std::array<std::uint64_t, 3> blocks{random() % 3, random() % 6, random() % blocks_};
      if (step % 16 == 0) session.prefetch(level_, random() % blocks_);
      if (step % 16 == 8) session.read_ahead(level_, random() % blocks_);
      std::array<PinnedBlock, 3> pinned;
      if (step % 4 == 0) {
        pinned[0] = session.pin(level_, blocks[0]);
      } else {
        const std::array requests{BlockRequest(level_, blocks[0]), BlockRequest(level_, blocks[1]),
                                  BlockRequest(level_, blocks[2])};
        session.pin_many(requests, pinned);
      }
      for (std::size_t i = 0; i < pinned.size(); ++i)
        if (pinned[i] && !shows_its_number(pinned[i], blocks[i])) ++wrong;
      if (step % 8 == 1) hand_over(pinned[static_cast<std::size_t>(step % 3)]);
      if (step % 2 == 0) PinnedBlock::release_all(pinned);
    }
  }
  /// The pin ends in the thread that hands over the next one.
  void hand_over(PinnedBlock& pinned) {
    std::vector<PinnedBlock> ended;
    const std::scoped_lock lock(mutex_);
    std::swap(ended, handed_over_);
    handed_over_.push_back(std::move(pinned));
  }

  const LevelFile& level_;
  std::uint64_t blocks_;
  std::array<Session, 2> sessions_;
  std::mutex mutex_;
  std::vector<PinnedBlock> handed_over_;
};

}  // namespace

TEST_CASE("PinCount_ClosedFrame_GetsNoPinWithoutTheLock") {
  PinCount pins;
  CHECK_FALSE(try_add(pins));
  pins.add(true);
  CHECK(try_add(pins));
  CHECK(pins.count() == 2);
  CHECK_FALSE(pins.close());
  CHECK_FALSE(try_add(pins));
  CHECK(pins.try_end());
  CHECK_FALSE(pins.try_end());  // the last one of a frame that is not placed
  CHECK(pins.count() == 1);
}

TEST_CASE("PinCount_LastPin_EndsWithoutTheLockOnlyIfTheFrameIsPlaced") {
  PinCount pins;
  pins.add(true);
  CHECK(pins.end());
  CHECK_FALSE(pins.is_open());
  pins.set_placed();
  pins.open();
  CHECK(try_add(pins));
  CHECK(pins.try_end());
  CHECK(try_add(pins));
  CHECK_FALSE(pins.end());  // it is still placed
  CHECK(pins.is_open());
}

TEST_CASE("PinCount_FrameThatGetsAnotherBlock_GetsNoPinOfTheFormer") {
  PinCount pins;
  pins.set_placed();
  pins.open();
  CHECK_FALSE(pins.try_add([] { return false; }));
  CHECK_FALSE(pins.try_add([&] {
    // The other thread is faster: it evicts the block, and opens the frame with another one.
    CHECK(pins.claim());
    pins.end_block();
    pins.open();
    return true;
  }));
  CHECK(pins.count() == 0);
  CHECK(try_add(pins));
}

TEST_CASE("PinCountClaim_FrameWithPins_IsNoLongerPlaced") {
  PinCount pins;
  pins.set_placed();
  pins.open();
  CHECK(try_add(pins));
  CHECK_FALSE(pins.claim());
  CHECK(pins.is_open());
  CHECK_FALSE(pins.try_end());
  CHECK(pins.end());
  CHECK(pins.claim());
  CHECK_FALSE(try_add(pins));
}

TEST_CASE("SessionCallers_ManyThreads_EachCountsItsPins") {
  SessionCallers callers;
  constexpr int kThreads = 20;
  std::latch counted(kThreads), seen(1);
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  std::atomic<int> missed = 0;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&] {
      SessionCaller* caller = callers.try_add(2);
      static std::mutex mutex;  // stands for the pager's lock
      if (!caller) {
        const std::scoped_lock lock(mutex);
        caller = &callers.add(2);
      }
      if (callers.try_add(1) != caller) ++missed;
      counted.count_down();
      seen.wait();
      caller->end(3);
    });
  counted.wait();
  int with_pins = 0;
  callers.any_of([&](std::uint32_t) { return ++with_pins == kThreads + 1; });
  CHECK(with_pins == kThreads);
  seen.count_down();
  for (std::thread& thread : threads) thread.join();
  CHECK_FALSE(callers.any_of([](std::uint32_t) { return true; }));
  CHECK(missed == 0);
}

TEST_CASE("SessionCallers_EndOfTheSession_IsCompleteWhenTheLastPinsEnd") {
  SessionCallers callers;
  SessionCaller& caller = callers.add(2);
  CHECK_FALSE(caller.end(1));
  CHECK_FALSE(callers.end_session());
  CHECK(caller.pins() == 1);
  CHECK(caller.end(1));
  CHECK(callers.end_one());
  SessionCallers others;
  others.add(1).end(1);
  CHECK(others.end_session());
}

TEST_CASE("OpenPins_WhileAnotherThreadHasThePagersLock_BeginAndEnd") {
  Pager pager(8 * kBlockBytes, 0);
  NumberedLevel warm(pager, 3), mapped(pager, 1, kMapped);
  const auto policy = GENERATE(EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock);
  Session session = pager.open_session({.policy = policy});
  for (std::uint64_t block = 0; block < 3; ++block) session.pin(warm.read_only(), block);

  std::latch has_lock(1), may_go_on(1);
  mapped.backend->before_address = [&] {
    has_lock.count_down();
    may_go_on.wait();
  };
  std::thread other([&] {
    Session own = pager.open_session();
    own.pin(mapped.read_only(), 0);
  });
  has_lock.wait();
  {
    const PinnedBlock one = session.pin(warm.read_only(), 1);
    CHECK(shows_its_number(one, 1));
    const std::vector<BlockRequest> requests{{warm.read_only(), 0}, {warm.read_only(), 2}};
    std::vector<PinnedBlock> pinned(2);
    session.pin_many(requests, pinned);
    CHECK(shows_its_number(pinned[0], 0));
    CHECK(shows_its_number(pinned[1], 2));
    PinnedBlock::release_all(pinned);
    CHECK(session.read_ahead(warm.read_only(), 1));
    CHECK(shows_its_number(session.pin(warm.read_only(), 1), 1));
  }
  may_go_on.count_down();
  other.join();
  mapped.backend->before_address = {};
}

TEST_CASE("OpenPins_BlockThatWillBeRead_IsNotTheNextVictim") {
  Pager pager(3 * kBlockBytes, 0);
  NumberedLevel level(pager, 8);
  Session session = pager.open_session({.policy = EvictionPolicy::kClock});
  // The hand has passed 1 and 2, and evicted 0.
  for (std::uint64_t block = 0; block < 4; ++block) session.pin(level.read_only(), block);
  CHECK(session.read_ahead(level.read_only(), 1));
  session.pin(level.read_only(), 4);
  const int reads = level.backend->reads;
  session.pin(level.read_only(), 1);
  CHECK(level.backend->reads == reads);
  session.pin(level.read_only(), 2);
  CHECK(level.backend->reads == reads + 1);
}

TEST_CASE("OpenPins_OfTheNextVictim_KeepItInMemory") {
  Pager pager(3 * kBlockBytes, 0);
  NumberedLevel level(pager, 16);
  const auto policy = GENERATE(EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock);
  Session session = pager.open_session({.policy = policy});
  for (std::uint64_t block = 0; block < 3; ++block) session.pin(level.read_only(), block);
  const int reads = level.backend->reads;
  {
    const PinnedBlock first = session.pin(level.read_only(), 0);
    const std::byte* const address = first.bytes().data();
    for (std::uint64_t block = 3; block < 16; ++block) session.pin(level.read_only(), block);
    CHECK(shows_its_number(first, 0));
    CHECK(session.pin(level.read_only(), 0).bytes().data() == address);
  }
  CHECK(level.backend->reads == reads + 13);
  CHECK(all_frames_can_be_had(pager, level.read_only(), 8));
}

TEST_CASE("OpenPins_OfASessionThatHasEnded_FreeTheirFramesWhenTheyEnd") {
  Pager pager(2 * kBlockBytes, 0);
  NumberedLevel level(pager, 8);
  std::vector<PinnedBlock> left;
  {
    Session session = pager.open_session();
    for (std::uint64_t block = 0; block < 2; ++block) session.pin(level.read_only(), block);
    for (std::uint64_t block = 0; block < 2; ++block)
      left.push_back(session.pin(level.read_only(), block));
  }
  CHECK(shows_its_number(left[1], 1));
  std::thread([&] { left.clear(); }).join();
  CHECK(all_frames_can_be_had(pager, level.read_only(), 4));
}

TEST_CASE("OpenPins_EndOfOne_WakesWhoWaitsForAFrame") {
  Pager pager(2 * kBlockBytes, 0);
  NumberedLevel level(pager, 8);
  Session walk = pager.open_session(), other = pager.open_session();
  for (std::uint64_t block = 0; block < 2; ++block) walk.pin(level.read_only(), block);
  PinnedBlock first = walk.pin(level.read_only(), 0), second = walk.pin(level.read_only(), 1);
  auto waits = std::async(std::launch::async, [&] { return other.pin(level.read_only(), 5); });
  CHECK(is_waiting(waits));
  second.release();
  CHECK(shows_its_number(waits.get(), 5));
  CHECK(shows_its_number(first, 0));
}

TEST_CASE("OpenPins_EndOfOneThatFreesNothing_TellsWhoWaitsThatNothingWillComeFree") {
  Pager pager(kBlockBytes, 0);
  NumberedLevel level(pager, 8);
  Session holding = pager.open_session(), asking = pager.open_session();
  std::latch has_own(1), other_has_it(1);
  auto refused = std::async(std::launch::async, [&] {
    const PinnedBlock own = asking.pin(level.read_only(), 3);
    has_own.count_down();
    other_has_it.wait();
    try {
      asking.pin(level.read_only(), 4);
    } catch (const Error& error) {
      return error.code() == ErrorCode::kBudget;
    }
    return false;
  });
  has_own.wait();
  PinnedBlock first = holding.pin(level.read_only(), 3), second = holding.pin(level.read_only(), 3);
  first.release();
  other_has_it.count_down();
  CHECK(is_waiting(refused));
  second.release();
  CHECK(refused.get());
}

TEST_CASE("OpenPins_EightThreadsWithFewFrames_SeeTheirBlocksBytes") {
  constexpr std::uint64_t kBlocks = 48;
  // Each of the threads has two blocks that others do not have, one lies between two threads, and
  // all use the first six.
  constexpr std::uint64_t kThreads = 8, kNeeded = 2 * kThreads + 1 + 6;
  const std::uint64_t frames = GENERATE(kNeeded + 1, kNeeded + 8);
  const int io_threads = GENERATE(0, 1);
  CAPTURE(frames, io_threads);
  Pager pager(frames * kBlockBytes, io_threads);
  NumberedLevel level(pager, kBlocks);
  {
    Crowd crowd(pager, level.read_only(), kBlocks);
    crowd.run(static_cast<unsigned>(kThreads), unless_sanitized(4000, 400));
    CHECK(crowd.wrong == 0);
  }
  const PagingStatistics done = pager.statistics();
  CHECK(done.blocks_evicted > 0);
  CHECK(done.peak_frame_bytes <= pager.budget_bytes());
  CHECK(all_frames_can_be_had(pager, level.read_only(), 2));
}
