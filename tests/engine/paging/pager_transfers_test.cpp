// What the pager does while blocks are on their way: a backend whose transfers end when the test
// says so, in the order it says, plays the disk.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <future>
#include <thread>
#include <vector>

#include "engine/paging/held_level.h"
#include "support/error_of.h"
#include "support/eventually.h"

using namespace plait;
using namespace plait::test;

TEST_CASE("PagerUnpin_DirtyBlock_IsWrittenAtOnceAndStaysResident") {
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  level.put(3, 99);
  level.backend->wait_until_started(0, 1);
  pager.flush();
  CHECK(level.backend->started_writes == 1);  // flush found it clean
  CHECK(level.pin(3, Access::kRead).bytes()[0] == std::byte{99});
  CHECK(level.backend->started_reads == 0);
  pager.detach(level.file);
}

TEST_CASE("PagerPin_BlockThatIsBeingWritten_IsSharedForReadingAndWaitsForWriting") {  // 8
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  level.backend->hold();
  level.put(0, 50);
  level.backend->wait_until_started(0, 1);
  CHECK(level.pin(0, Access::kRead).bytes()[7] == std::byte{50});
  for (const Access access : {Access::kUpdate, Access::kOverwrite}) {
    auto changed = std::async(std::launch::async, [&] {
      PinnedBlock pinned = level.pin(0, access);
      std::memset(pinned.bytes().data(), 51, kBlockBytes);
    });
    CHECK(is_waiting(changed));
    level.backend->let_go(Direction::kWrite, 0);
    changed.get();
    level.backend->wait_until_started(0, access == Access::kUpdate ? 2 : 3);
  }
  CHECK(pager.statistics().write_waits <= 2);  // by those that came before the write had ended
  level.backend->let_all_go();
  pager.flush();
  CHECK(pager.statistics().blocks_written == 3);
  pager.detach(level.file);
}

TEST_CASE("PagerPin_OtherBlocks_DoNotWaitForOneOnItsWay") {  // 9
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  HeldLevel other(pager, 8);
  level.backend->hold();
  auto slow = std::async(std::launch::async, [&] { level.pin(0, Access::kRead); });
  level.backend->wait_until_started(1, 0);
  CHECK(other.pin(1, Access::kRead).bytes()[0] == HeldLevel::value(1));
  CHECK(is_waiting(slow));
  level.backend->let_all_go();
  slow.get();
  pager.detach(level.file);
  pager.detach(other.file);
}

TEST_CASE("PagerPin_SameBlockFromTwoThreads_IsReadOnce") {  // 3
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  level.backend->hold();
  const auto read = [&] { return level.pin(2, Access::kRead).bytes()[9]; };
  auto first = std::async(std::launch::async, read);
  level.backend->wait_until_started(1, 0);
  auto second = std::async(std::launch::async, read);
  CHECK(is_waiting(second));
  level.backend->let_all_go();
  CHECK(first.get() == HeldLevel::value(2));
  CHECK(second.get() == HeldLevel::value(2));
  CHECK(level.backend->started_reads == 1);
  pager.detach(level.file);
}

TEST_CASE("PagerPrefetch_Thread_ReadsAheadWithoutTakingWhatIsNeeded") {
  Pager pager(6 * kBlockBytes, 1);
  HeldLevel level(pager, 16, {.window_bytes = 2 * kBlockBytes});
  const PinnedBlock current = level.pin(0, Access::kRead);
  std::uint64_t ahead = 1;
  while (level.session.prefetch(level.file, ahead)) ++ahead;
  CHECK(ahead == 5);  // six frames, two of them for pins
  for (std::uint64_t block = 1; block < ahead; ++block)
    CHECK(level.pin(block, Access::kRead).bytes()[1] == HeldLevel::value(block));
  CHECK(level.backend->started_reads == 5);
  CHECK(pager.statistics().blocks_prefetched == 4);
  CHECK(level.session.prefetch(level.file, ahead));  // those behind make room
  pager.discard();
}

TEST_CASE("PagerPrefetch_ManyBlocks_KeepsToTheBoundInFlight") {
  Pager pager(64 * kBlockBytes, 2);
  HeldLevel level(pager, 32);
  level.backend->hold();
  std::uint64_t ahead = 0;
  while (level.session.prefetch(level.file, ahead)) ++ahead;
  CHECK(ahead == Pager::kInFlight);
  level.backend->let_go(Direction::kRead, 3);
  CHECK(level.session.prefetch(level.file, ahead));
  level.backend->let_all_go();
  CHECK(level.pin(3, Access::kRead).bytes()[0] == HeldLevel::value(3));
  pager.detach(level.file);
}

TEST_CASE("PagerUnpin_ManyDirtyBlocks_KeepsToTheBoundAndEvictsNoneUnwritten") {  // 4
  Pager pager(16 * kBlockBytes, 1);
  HeldLevel level(pager, 64);
  level.backend->hold();
  for (std::uint64_t block = 0; block < 16; ++block) level.put(block, 70);
  level.backend->wait_until_started(0, Pager::kInFlight);
  CHECK(level.backend->started_writes == Pager::kInFlight);
  auto next = std::async(std::launch::async, [&] { level.put(16, 71); });
  CHECK(is_waiting(next));
  level.backend->let_go(Direction::kWrite, 5);
  next.get();
  level.backend->let_all_go();
  pager.flush();
  for (std::uint64_t block = 0; block < 16; ++block)
    CHECK(level.pin(block, Access::kRead).bytes()[0] == std::byte{70});
  CHECK(pager.statistics().peak_frame_bytes <= 16 * kBlockBytes);
  CHECK(pager.statistics().blocks_written == 17);
  pager.detach(level.file);
}

TEST_CASE("PagerUnpin_WriteBehindFails_ReachesTheNextWriterOnceAndKeepsTheBytes") {  // 7
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  level.backend->hold();
  level.put(0, 42);
  level.backend->let_go(Direction::kWrite, 0, true);
  const bool by_flush = GENERATE(true, false);
  const auto ask = [&] {
    by_flush ? pager.flush() : static_cast<void>(level.pin(1, Access::kUpdate));
  };
  CHECK(code_of(ask) == ErrorCode::kNoSpace);
  CHECK(code_of(ask) == ErrorCode::kBadState);
  CHECK(code_of([&] { pager.flush(); }) == ErrorCode::kBadState);
  level.backend->let_all_go();
  // It reads, in what frames are left, and the block that could not be written is still there.
  for (std::uint64_t block = 1; block < 8; ++block)
    CHECK(level.pin(block, Access::kRead).bytes()[0] == HeldLevel::value(block));
  CHECK(level.pin(0, Access::kRead).bytes()[0] == std::byte{42});
  pager.discard();
}

TEST_CASE("PagerPrefetch_ReadFails_IsReportedByThePinThatNeedsTheBlock") {
  Pager pager(4 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  level.file.table.entries()[2].checksum ^= 1;
  CHECK(level.session.prefetch(level.file, 2));
  CHECK(code_of([&] { level.pin(2, Access::kRead); }) == ErrorCode::kCorruption);
  level.file.table.entries()[2].checksum ^= 1;
  CHECK(level.pin(2, Access::kRead).bytes()[0] == HeldLevel::value(2));
  pager.detach(level.file);
}

TEST_CASE("PagerUnpin_QueuedBlockPinnedAgain_IsNotWrittenBeforeItIsReleased") {
  Pager pager(16 * kBlockBytes, 1);
  HeldLevel level(pager, 16);
  level.backend->hold();
  constexpr std::uint64_t kLast = Pager::kInFlight;
  for (std::uint64_t block = 0; block <= kLast; ++block) level.put(block, 70);
  level.backend->wait_until_started(0, Pager::kInFlight);
  PinnedBlock again = level.pin(kLast, Access::kUpdate);
  std::memset(again.bytes().data(), 71, kBlockBytes / 2);
  level.backend->let_all_go();
  while (pager.statistics().blocks_written < Pager::kInFlight) std::this_thread::yield();
  CHECK(level.backend->started_writes == static_cast<int>(Pager::kInFlight));
  std::memset(again.bytes().data(), 72, kBlockBytes);
  again.release();
  pager.flush();
  CHECK(level.backend->started_writes == static_cast<int>(Pager::kInFlight) + 1);
  pager.discard();
  CHECK(level.pin(kLast, Access::kRead).bytes()[0] == std::byte{72});
  pager.detach(level.file);
}

TEST_CASE("PagerFlush_BlockThatIsPinnedForWriting_IsWrittenAgainAfterItsRelease") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  HeldLevel level(pager, 8);
  PinnedBlock held = level.pin(2, Access::kUpdate);
  std::memset(held.bytes().data(), 60, kBlockBytes);
  pager.flush();
  CHECK(level.backend->started_writes == 1);
  std::memset(held.bytes().data(), 61, kBlockBytes);
  held.release();
  pager.flush();
  CHECK(level.backend->started_writes == 2);
  pager.discard();
  CHECK(level.pin(2, Access::kRead).bytes()[0] == std::byte{61});
  pager.detach(level.file);
}

// Who is told first that the read has ended is the system's choice: several wait, several times.
TEST_CASE("PagerPin_ReadFailsWhileOthersWaitForIt_TheOthersReadForThemselves") {
  for (int round = 0; round < 20; ++round) {
    Pager pager(4 * kBlockBytes, 1);
    HeldLevel level(pager, 8);
    level.backend->hold();
    auto failing = std::async(std::launch::async,
                              [&] { return code_of([&] { level.pin(5, Access::kRead); }); });
    level.backend->wait_until_started(1, 0);
    std::vector<std::future<bool>> waiting;
    for (int i = 0; i < 6; ++i)
      waiting.push_back(std::async(std::launch::async, [&] {
        return level.pin(5, Access::kRead).bytes()[100] == HeldLevel::value(5);
      }));
    CHECK(eventually(other_threads_sleep));
    level.backend->let_go(Direction::kRead, 5, true);
    CHECK(failing.get() == ErrorCode::kNoSpace);
    level.backend->let_all_go();
    for (auto& other : waiting) CHECK(other.get());
    pager.detach(level.file);
  }
}

TEST_CASE("PagerEvict_BlockWhoseWriteFailed_StaysSinceItIsTheOnlyCopy") {  // 4, 7
  const int io_threads = GENERATE(0, 1);
  const auto policy = GENERATE(EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock);
  const bool announced = GENERATE(false, true);
  Pager pager(3 * kBlockBytes, io_threads);
  HeldLevel level(pager, 16, {.policy = policy});
  level.backend->fail_writes = true;
  level.put(3, 42);
  if (announced) level.session.prefetch(level.file, 3);
  CHECK(code_of([&] { pager.flush(); }) == ErrorCode::kNoSpace);
  if (announced) level.session.prefetch(level.file, 3);
  level.backend->fail_writes = false;
  for (int round = 0; round < 2; ++round)
    for (std::uint64_t block = 4; block < 16; ++block)
      CHECK(level.pin(block, Access::kRead).bytes()[0] == HeldLevel::value(block));
  CHECK(level.pin(3, Access::kRead).bytes()[0] == std::byte{42});
  for (std::uint64_t block = 4; block < 16; ++block)
    CHECK(level.pin(block, Access::kRead).bytes()[0] == HeldLevel::value(block));
  CHECK(level.pin(3, Access::kRead).bytes()[0] == std::byte{42});
  pager.discard();
}

TEST_CASE("PagerPin_AllFramesPinnedButOneIsBeingRead_WaitsForTheRead") {
  Pager pager(2 * kBlockBytes, 1);
  HeldLevel level(pager, 8);
  const PinnedBlock held = level.pin(0, Access::kRead);
  level.backend->hold();
  auto reading =
      std::async(std::launch::async, [&] { return code_of([&] { level.pin(1, Access::kRead); }); });
  level.backend->wait_until_started(2, 0);
  auto waiting = std::async(std::launch::async, [&] { level.pin(2, Access::kRead); });
  CHECK(is_waiting(waiting));
  // Its frame is free again as soon as the read has failed.
  level.backend->let_go(Direction::kRead, 1, true);
  CHECK(reading.get() == ErrorCode::kNoSpace);
  level.backend->let_go(Direction::kRead, 2);
  waiting.get();
  level.backend->let_all_go();
}

TEST_CASE("PagerDiscard_TransfersOnTheirWay_AreWaitedFor") {
  Pager pager(16 * kBlockBytes, 1);
  HeldLevel level(pager, 16);
  level.backend->hold();
  level.put(0, 1);
  CHECK(level.session.prefetch(level.file, 4));
  level.backend->wait_until_started(1, 1);
  auto discarded = std::async(std::launch::async, [&] { pager.discard(); });
  CHECK(is_waiting(discarded));
  level.backend->let_all_go();
  discarded.get();
  CHECK(level.pin(9, Access::kRead).bytes()[0] == HeldLevel::value(9));
  pager.detach(level.file);
}

TEST_CASE("Pager_FourThreadsThatFillBlocksInOrder_WriteEachOnceBehindTheirBacks") {
  constexpr std::uint64_t kBlocks = 400;
  Pager pager(12 * kBlockBytes, GENERATE(1, 2));
  HeldLevel level(pager, 200), other(pager, 200);
  std::atomic<std::uint64_t> next = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (std::uint64_t n = next++; n < kBlocks; n = next++)
        (n % 2 == 0 ? level : other).put(n / 2, static_cast<int>(n % 251));
    });
  for (std::thread& thread : threads) thread.join();
  pager.flush();
  CHECK(pager.statistics().blocks_written == kBlocks);
  CHECK(pager.statistics().blocks_read == 0);
  bool same = true;
  for (std::uint64_t n = 0; n < kBlocks; ++n)
    same = same && (n % 2 == 0 ? level : other).pin(n / 2, Access::kRead).bytes()[5] ==
                       static_cast<std::byte>(n % 251);
  CHECK(same);
  pager.detach(level.file);
  pager.detach(other.file);
}
