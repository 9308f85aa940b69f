// The pager's invariants (plait/extend/pager.h), by number where a case pins one.
#include "plait/extend/pager.h"

#include <pthread.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "engine/paging/fake_level.h"
#include "plait/error.h"
#include "support/sanitized.h"

using namespace plait;
using namespace plait::test;

namespace {

void random_pins(EvictionPolicy policy, const BackendTraits& traits, int io_threads,
                 unsigned seed) {
  constexpr std::uint64_t kBudget = 8 * kBlockBytes;
  Pager pager(kBudget, io_threads);
  Session session = pager.open_session({.policy = policy});
  TestLevel level(pager, 3, 256 * 32, traits);
  const std::uint64_t blocks = level.file.geometry.block_count();
  REQUIRE(blocks == 32);
  std::vector<unsigned char> expected(blocks, 0);
  std::map<std::uint64_t, std::vector<PinnedBlock>> held;
  std::map<std::uint64_t, std::byte*> addresses;
  std::mt19937 random(seed);
  for (int step = 0; step < unless_sanitized(20'000, 5'000); ++step) {
    const std::uint64_t block = random() % blocks;
    if (random() % 4 == 0) session.prefetch(level.file, random() % blocks);
    if (random() % 2 == 0 && !held.empty()) {
      const auto victim =
          std::next(held.begin(), static_cast<std::ptrdiff_t>(random() % held.size()));
      victim->second.pop_back();
      if (victim->second.empty()) {
        addresses.erase(victim->first);
        held.erase(victim);
      }
      continue;
    }
    if (held.size() == 8 && !held.contains(block)) {
      REQUIRE_THROWS_AS(session.pin(level.file, block, Access::kRead), Error);
      continue;
    }
    const auto access = static_cast<Access>(random() % 3);
    PinnedBlock pinned = session.pin(level.file, block, access);
    // Invariants 2 and 3.
    const auto [known, fresh] = addresses.try_emplace(block, pinned.bytes().data());
    REQUIRE((fresh || known->second == pinned.bytes().data()));
    if (access != Access::kOverwrite) REQUIRE(holds(pinned, expected[block]));
    if (access != Access::kRead) {
      expected[block] = static_cast<unsigned char>(random());
      fill(pinned, expected[block]);
    }
    held[block].push_back(std::move(pinned));
    REQUIRE(pager.statistics().peak_frame_bytes <= kBudget);  // invariant 1
  }
  held.clear();
  pager.flush();
  for (std::uint64_t block = 0; block < blocks; ++block)
    REQUIRE(holds(session.pin(level.file, block, Access::kRead), expected[block]));
  pager.discard();
  pager.detach(level.file);
}

}  // namespace

TEST_CASE("Pager_RandomPins_ServesWhatWasWrittenWithinTheBudget") {
  for (const EvictionPolicy policy : {EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock})
    for (const BackendTraits& traits : {kFramed, kInMemory})
      for (const int io_threads : {0, 1, 3})
        random_pins(policy, traits, io_threads, traits.in_memory ? 1 : 2);
}

TEST_CASE("PagerPin_WriteAccess_ReadsNothing") {  // invariant 5
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 16 * 4096);
  for (std::uint64_t block = 0; block < 16; ++block)
    fill(session.pin(level.file, block, Access::kOverwrite), 7);
  pager.flush();
  CHECK(level.backend->reads == 0);
  CHECK(level.backend->writes == 16);
  CHECK(pager.statistics().blocks_evicted == 12);
}

TEST_CASE("PagerWindow_NextSweep_EvictsWhatTheLastOneLeftAhead") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 16 * 4096);
  for (std::uint64_t block = 0; block < 16; ++block)
    session.pin(level.file, block, Access::kOverwrite);
  pager.flush();  // what is being written goes later
  session = pager.open_session();
  for (std::uint64_t block = 0; block < 4; ++block) session.pin(level.file, block, Access::kRead);
  level.backend->reads = 0;
  for (std::uint64_t block = 0; block < 4; ++block) session.pin(level.file, block, Access::kRead);
  CHECK(level.backend->reads == 0);
}

TEST_CASE("PagerPin_NeverWrittenBlock_IsZeroEvenInARecycledFrame") {
  Pager pager(kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 2 * 4096);
  fill(session.pin(level.file, 0, Access::kOverwrite), 9);
  CHECK(holds(session.pin(level.file, 1, Access::kRead), 0));
  CHECK(level.backend->reads == 0);
}

TEST_CASE("PagerPin_NeverWrittenBlockWithAnAddress_IsZeroWhateverIsThere") {
  for (const BackendTraits& traits : {kInMemory, kMapped}) {
    Pager pager(2 * kBlockBytes, 1);
    Session session = pager.open_session();
    TestLevel level(pager, 1, 2 * 4096, traits);
    std::memset(level.backend->address_of(0), 1, kBlockBytes);
    CHECK(holds(session.pin(level.file, 0, Access::kRead), 0));
    CHECK((*level.backend->address_of(0) == std::byte{0}) == traits.in_memory);
  }
}

TEST_CASE("PagerPin_ForWritingALevelOpenedForReading_IsRefusedAndReadsOn") {
  for (const BackendTraits& traits : {kFramed, kMapped}) {
    Pager pager(2 * kBlockBytes, 1);
    Session session = pager.open_session();
    TestLevel level(pager, 1, 2 * 4096, traits);
    level.file.writable = false;
    level.put_on_disk(0, 5);
    for (const Access access : {Access::kOverwrite, Access::kUpdate}) {
      try {
        session.pin(level.file, 0, access);
        FAIL("expected an error");
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kBadState);
        CHECK(std::string_view(error.what()) == "write fake: the level was opened for reading");
      }
    }
    CHECK(holds(session.pin(level.file, 0, Access::kRead), 5));
  }
}

TEST_CASE("PagerPin_MappedLevel_IsServedWhereItLiesUnlessItIsWritten") {
  for (const bool writable : {false, true}) {
    Pager pager(2 * kBlockBytes, 1);
    Session session = pager.open_session();
    TestLevel level(pager, 1, 2 * 4096, kMapped);
    level.file.writable = writable;
    level.put_on_disk(1, 6);
    const PinnedBlock pinned = session.pin(level.file, 1, Access::kRead);
    CHECK(holds(pinned, 6));
    CHECK((pinned.bytes().data() == level.backend->address_of(1)) == !writable);
    if (!writable) continue;
    // One frame for all pins of a block: whoever reads sees what whoever writes has stored.
    fill(session.pin(level.file, 1, Access::kUpdate), 7);
    CHECK(holds(pinned, 7));
    pager.flush();
    CHECK(*level.backend->address_of(1) == std::byte{7});
  }
}

TEST_CASE("PinnedBlockAbandon_HalfWrittenBlock_IsNeverWrittenAndItsLevelIsUnfinished") {
  for (const BackendTraits& traits : {kFramed, kInMemory})
    for (const Access access : {Access::kOverwrite, Access::kUpdate}) {
      Pager pager(2 * kBlockBytes, GENERATE(0, 1));
      Session session = pager.open_session();
      TestLevel level(pager, 1, 4 * 4096, traits);
      fill(session.pin(level.file, 0, Access::kOverwrite), 1);
      pager.flush();
      const int writes = level.backend->writes;
      PinnedBlock half = session.pin(level.file, 1, access);
      fill(half, 9);
      CHECK(level.file.is_finished());
      half.abandon();
      CHECK_FALSE(half);
      CHECK_FALSE(level.file.is_finished());
      pager.flush();
      CHECK(level.backend->writes == writes);
      CHECK(holds(session.pin(level.file, 1, Access::kRead), 0));
      CHECK(holds(session.pin(level.file, 0, Access::kRead), 1));
      level.file.left_unfinished = false;
      session.pin(level.file, 0, Access::kRead).abandon();
      CHECK(level.file.is_finished());
      pager.detach(level.file);
    }
}

TEST_CASE("PagerPin_AllFramesPinned_ThrowsBudgetAndRecovers") {
  Pager pager(2 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 3 * 4096);
  PinnedBlock first = session.pin(level.file, 0, Access::kRead);
  const PinnedBlock second = session.pin(level.file, 1, Access::kRead);
  try {
    session.pin(level.file, 2, Access::kRead);
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBudget);
  }
  first.release();
  CHECK(session.pin(level.file, 2, Access::kRead));
}

TEST_CASE("PagerPin_RefusedHalfway_LeavesNothingBehind") {  // invariant 10
  const auto access = GENERATE(Access::kRead, Access::kOverwrite, Access::kUpdate);
  SECTION("because no frame can be had: the block that is in the way cannot be written") {
    Pager pager(3 * kBlockBytes, 0);
    Session session = pager.open_session({.policy = EvictionPolicy::kClock});
    TestLevel level(pager, 1, 8 * 4096);
    for (const unsigned block : {2u, 3u, 4u})
      level.put_on_disk(block, static_cast<unsigned char>(block));
    fill(session.pin(level.file, 0, Access::kOverwrite), 10);
    fill(session.pin(level.file, 1, Access::kOverwrite), 11);
    session.pin(level.file, 2, Access::kRead);
    level.backend->fail_writes = true;
    CHECK_THROWS_AS(session.pin(level.file, 3, access), Error);
    level.backend->fail_writes = false;
    // What was refused is absent: it is read, and its bytes are those of the backend.
    const int reads = level.backend->reads;
    CHECK(holds(session.pin(level.file, 3, Access::kRead), 3));
    CHECK(level.backend->reads == reads + 1);
    CHECK(holds(session.pin(level.file, 4, Access::kRead), 4));
    CHECK(holds(session.pin(level.file, 0, Access::kRead), 10));
    CHECK(holds(session.pin(level.file, 1, Access::kRead), 11));
    pager.discard();
  }
  SECTION("because the level cannot say where the block is") {
    Pager pager(2 * kBlockBytes, 1);
    Session session = pager.open_session();
    TestLevel level(pager, 1, 4 * 4096, kInMemory);
    level.backend->fail_addresses = true;
    const std::vector<BlockRequest> requests{{level.file, 0, access}, {level.file, 1, access}};
    std::vector<PinnedBlock> pinned(2);
    CHECK_THROWS_AS(session.pin_many(requests, pinned), Error);
    CHECK(pager.statistics().peak_frame_bytes == 0);
    level.backend->fail_addresses = false;
    session.pin_many(requests, pinned);
    CHECK(pager.statistics().peak_frame_bytes == 2 * kBlockBytes);
    pinned.clear();
  }
}

TEST_CASE("PagerSetAside_PartOfTheBudget_IsNotForFrames") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 8 * 4096);
  for (std::uint64_t block = 0; block < 4; ++block) session.pin(level.file, block, Access::kRead);
  pager.set_aside(2 * kBlockBytes);
  CHECK(pager.budget_bytes() == 2 * kBlockBytes);
  const PinnedBlock first = session.pin(level.file, 4, Access::kRead);
  const PinnedBlock second = session.pin(level.file, 5, Access::kRead);
  CHECK_THROWS_AS(session.pin(level.file, 6, Access::kRead), Error);
}

TEST_CASE("LentMemory_WhileItLives_IsNotForFrames") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 8 * 4096);
  for (std::uint64_t block = 0; block < 4; ++block) session.pin(level.file, block, Access::kRead);
  {
    const LentMemory one(pager, kBlockBytes), other(pager, kBlockBytes);
    CHECK(pager.budget_bytes() == 2 * kBlockBytes);
    const PinnedBlock first = session.pin(level.file, 4, Access::kRead);
    const PinnedBlock second = session.pin(level.file, 5, Access::kRead);
    CHECK_THROWS_AS(session.pin(level.file, 6, Access::kRead), Error);
    const LentMemory beyond(pager, 8 * kBlockBytes);
    CHECK(pager.budget_bytes() == 0);
  }
  CHECK(pager.budget_bytes() == 4 * kBlockBytes);
  std::vector<PinnedBlock> all;
  for (std::uint64_t block = 0; block < 4; ++block)
    all.push_back(session.pin(level.file, block, Access::kRead));
  CHECK(all.size() == 4);
}

TEST_CASE("UnfinishedLevels_UntilFinish_AndForGoodWithoutIt") {
  Pager pager(2 * kBlockBytes, 0);
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4096);
  {
    UnfinishedLevels pass;
    pass.add(level.file, Access::kRead);
    CHECK(level.file.is_finished());
    pass.add(level.file, Access::kUpdate);
    CHECK_FALSE(level.file.is_finished());
    pass.finish();
    CHECK(level.file.is_finished());
    pass.add(level.file, Access::kOverwrite);
  }
  CHECK_FALSE(level.file.is_finished());
  UnfinishedLevels update;
  update.add(level.file, Access::kUpdate);
  update.finish();
  CHECK_FALSE(level.file.is_finished());  // it changed what is not whole
  UnfinishedLevels outer, inner;
  outer.add(level.file, Access::kUpdate);
  inner.add(level.file, Access::kOverwrite);
  inner.finish();
  CHECK_FALSE(level.file.is_finished());
  outer.finish();
  CHECK(level.file.is_finished());
}

// A thread needs a stack, and nobody has one of so many bytes.
TEST_CASE("PagerAttach_ThreadsThatCannotBeHad_IsOutOfMemory") {
  pthread_attr_t usual, huge;
  REQUIRE(::pthread_getattr_default_np(&usual) == 0);
  REQUIRE(::pthread_getattr_default_np(&huge) == 0);
  REQUIRE(::pthread_attr_setstacksize(&huge, std::size_t{1} << 46) == 0);
  REQUIRE(::pthread_setattr_default_np(&huge) == 0);
  std::optional<ErrorCode> code;
  {
    Pager pager(2 * kBlockBytes, 2);
    Session session = pager.open_session();
    try {
      TestLevel level(pager, 1, 4096);
    } catch (const Error& error) {
      code = error.code();
    }
  }
  REQUIRE(::pthread_setattr_default_np(&usual) == 0);
  CHECK(code == ErrorCode::kOutOfMemory);
}

TEST_CASE("PagerWindow_LevelsOfDifferentFineness_KeepTheSameEdges") {
  Pager pager(4 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel coarse(pager, 1, 8 * 4096), fine(pager, 2, 8 * 4096);
  // One coarse block spans four fine ones; it came first, but it ends furthest ahead.
  session.pin(coarse.file, 0, Access::kOverwrite);
  for (std::uint64_t block = 0; block < 3; ++block)
    session.pin(fine.file, block, Access::kOverwrite);
  pager.flush();
  session.pin(fine.file, 3, Access::kOverwrite);
  session.pin(coarse.file, 0, Access::kRead);
  CHECK(coarse.backend->reads == 0);
  session.pin(fine.file, 0, Access::kRead);
  CHECK(fine.backend->reads == 1);
}

TEST_CASE("PagerClock_BlockUsedAgain_OutlivesOneThatWasNot") {
  Pager pager(3 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session({.policy = EvictionPolicy::kClock});
  TestLevel level(pager, 1, 8 * 4096);
  for (std::uint64_t block = 0; block < 8; ++block)
    session.pin(level.file, block, Access::kOverwrite);
  pager.flush();
  pager.discard();
  level.backend->reads = 0;
  for (std::uint64_t block = 0; block < 4; ++block)
    session.pin(level.file, block, Access::kRead);  // evicts one
  session.pin(level.file, 2, Access::kRead);
  session.pin(level.file, 4, Access::kRead);
  session.pin(level.file, 2, Access::kRead);
  CHECK(level.backend->reads == 5);
}

TEST_CASE("PagerEvict_FailedWrite_RefusesWritesAndFlushButReads") {  // invariant 7
  Pager pager(2 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4 * 4096);
  fill(session.pin(level.file, 0, Access::kOverwrite), 1);
  pager.flush();
  {
    const auto block = session.pin(level.file, 1, Access::kOverwrite);
    fill(block, 2);
    level.backend->fail_writes = true;  // before a transfer thread can write the block behind
  }
  CHECK_THROWS_AS(pager.flush(), Error);
  level.backend->fail_writes = false;
  for (const auto& attempt :
       {std::function<void()>([&] { pager.flush(); }),
        std::function<void()>([&] { session.pin(level.file, 2, Access::kOverwrite); })}) {
    try {
      attempt();
      FAIL("expected an error");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBadState);
    }
  }
  CHECK(holds(session.pin(level.file, 0, Access::kRead), 1));
  CHECK(holds(session.pin(level.file, 1, Access::kRead), 2));
}

TEST_CASE("PagerPin_MappedBlockWithAFlippedByte_IsCorruption") {  // invariant 6
  Pager pager(2 * kBlockBytes, GENERATE(0, 1));
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4 * 4096, kMapped);
  level.put_on_disk(0, 5);
  level.backend->address_of(0)[17] ^= std::byte{4};
  try {
    session.pin(level.file, 0, Access::kRead);
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruption);
  }
  level.backend->address_of(0)[17] ^= std::byte{4};
  CHECK(holds(session.pin(level.file, 0, Access::kRead), 5));
}

TEST_CASE("PagerPrefetch_NoThreads_ReadsNothing") {
  Pager pager(2 * kBlockBytes, 0);
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4 * 4096);
  for (std::uint64_t block = 0; block < 3; ++block)
    fill(session.pin(level.file, block, Access::kOverwrite), 1);
  // 0 is evicted, 1 and 2 are resident, 3 was never written.
  for (std::uint64_t block = 0; block < 4; ++block) CHECK(session.prefetch(level.file, block));
  CHECK(level.backend->reads == 0);
  CHECK(pager.statistics().blocks_prefetched == 0);
}

TEST_CASE("PagerReadAhead_WithAThread_ReadsAbsentBlocksOnly") {
  Pager pager(2 * kBlockBytes, 1);
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4 * 4096);
  fill(session.pin(level.file, 0, Access::kOverwrite), 1);
  pager.flush();
  CHECK(session.read_ahead(level.file, 0));
  CHECK(pager.statistics().blocks_prefetched == 0);
  pager.discard();
  CHECK(session.read_ahead(level.file, 0));
  CHECK(pager.statistics().blocks_prefetched == 1);
  CHECK(holds(session.pin(level.file, 0, Access::kRead), 1));
  CHECK(level.backend->reads == 1);
}

TEST_CASE("PagerPrefetch_WithAThread_ReadsTheBlock") {
  Pager pager(2 * kBlockBytes, 1);
  Session session = pager.open_session();
  TestLevel level(pager, 1, 4 * 4096);
  fill(session.pin(level.file, 0, Access::kOverwrite), 1);
  pager.flush();
  pager.discard();
  CHECK(session.prefetch(level.file, 0));
  CHECK(holds(session.pin(level.file, 0, Access::kRead), 1));
  CHECK(level.backend->reads == 1);
  CHECK(pager.statistics().blocks_prefetched == 1);
}
