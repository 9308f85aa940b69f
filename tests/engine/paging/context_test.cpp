// Blocks that are coded by coarser ones: a backend that stores every block as its difference from
// the block of the level before that has its first edge.
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "plait/extend/pager.h"
#include "support/error_of.h"
#include "support/eventually.h"

using namespace plait;
using plait::test::code_of;
using plait::test::eventually;
using plait::test::other_threads_sleep;

namespace {

constexpr std::uint64_t kContextBlockBytes = 4096;
constexpr EdgeId kEdges = 8192;
constexpr int kLevels = 3;  // of 2, 8 and 32 blocks

struct Log {
  std::mutex mutex;
  std::vector<ContextBlock> reads;  ///< in the order in which they began
  std::atomic<bool> misnamed = false;
  bool by_first_block = false;  ///< every block is coded by block 0 of the coarser level
  std::function<void(int level, const Transfer&)> before;  ///< before a transfer moves a byte
};

class DifferenceBackend final : public Backend {
 public:
  DifferenceBackend(LevelFile& level, const LevelFile* coarser, Log& log)
      : level_(level), coarser_(coarser), log_(log), stored_(level.geometry.total_bytes()) {}

  void read(BlockRange, std::span<std::byte>) override { refuse(); }
  void write(BlockRange, std::span<const std::byte>) override { refuse(); }
  void start(Transfer& transfer) noexcept override {
    std::exception_ptr error;
    if (log_.before) log_.before(level_.table.level(), transfer);
    try {
      transfer.direction == Transfer::Direction::kRead ? decode(transfer) : encode(transfer);
    } catch (...) {
      error = std::current_exception();
    }
    transfer.listener->finished(transfer, error);
  }
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    if (!coarser_) return 0;
    blocks[0] = {
        0, coarser_->table.level(),
        log_.by_first_block ? 0 : coarser_->geometry.block_of(level_.geometry.first_edge(block))};
    if (log_.misnamed) blocks[0] = {0, level_.table.level(), block};
    return 1;
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return stored_.size(); }

  std::span<std::byte> stored(std::uint64_t block) {
    return std::span(stored_).subspan(level_.geometry.block_offset(block),
                                      level_.geometry.block_bytes(block));
  }

 private:
  [[noreturn]] static void refuse() {
    throw Error(ErrorCode::kNotSupported, "difference: a block needs its context");
  }
  std::byte context_byte(const Transfer& transfer, std::size_t i) const {
    return coarser_ ? transfer.context[0][i] : std::byte{0};
  }
  void check_context(const Transfer& transfer) const {
    if (transfer.context.size() != (coarser_ ? 1u : 0u))
      throw Error(ErrorCode::kBadState, "difference: the context is not there");
  }
  void decode(const Transfer& transfer) {
    {
      const std::scoped_lock lock(log_.mutex);
      log_.reads.push_back({0, level_.table.level(), transfer.block});
    }
    check_context(transfer);
    const std::span<std::byte> from = stored(transfer.block);
    level_.table.check(transfer.block, from, "difference");
    for (std::size_t i = 0; i < from.size(); ++i)
      transfer.memory[i] = from[i] ^ context_byte(transfer, i);
  }
  void encode(const Transfer& transfer) {
    check_context(transfer);
    const std::span<std::byte> into = stored(transfer.block);
    for (std::size_t i = 0; i < into.size(); ++i)
      into[i] = transfer.memory[i] ^ context_byte(transfer, i);
    level_.table.seal(transfer.block, level_.geometry.block_offset(transfer.block),
                      BlockEncoding::kEncoded, into);
  }

  LevelFile& level_;
  const LevelFile* coarser_;
  Log& log_;
  std::vector<std::byte> stored_;
};

std::byte value(int level, std::uint64_t block, std::size_t i) {
  return static_cast<std::byte>(31 * static_cast<std::size_t>(level) + 7 * block + i / 64);
}

bool holds_its_values(const PinnedBlock& pinned, int level, std::uint64_t block) {
  for (std::size_t i = 0; i < pinned.bytes().size(); ++i)
    if (pinned.bytes()[i] != value(level, block, i)) return false;
  return true;
}

/// Levels 1 to 3, written by way of one pager, then attached to that of the test.
struct Levels {
  Levels() {
    for (int number = 1; number <= kLevels; ++number) {
      LevelFile& level = at(number);
      level.path = "difference" + std::to_string(number);
      level.geometry =
          LevelGeometry(SlotShapes(kEdges), BaseRelativeLevel(number), 1, kContextBlockBytes);
      level.table = BlockTable({}, 0, number, level.geometry.block_count());
      level.traits = {.durable = true, .compressed = true};
      level.backend =
          std::make_unique<DifferenceBackend>(level, number > 1 ? &at(number - 1) : nullptr, log);
    }
  }
  LevelFile& at(int number) { return files[static_cast<std::size_t>(number - 1)]; }
  std::span<std::byte> stored(int number, std::uint64_t block) {
    return static_cast<DifferenceBackend&>(*at(number).backend).stored(block);
  }
  void attach(Pager& pager) {
    for (LevelFile& file : files) pager.attach(file);
  }
  void detach(Pager& pager) {
    pager.discard();
    for (LevelFile& file : files) pager.detach(file);
  }
  void fill(Pager& pager, EvictionPolicy policy) {
    Session session = pager.open_session({.policy = policy});
    for (int number = 1; number <= kLevels; ++number)
      for (std::uint64_t block = 0; block < at(number).geometry.block_count(); ++block) {
        const PinnedBlock pinned = session.pin(at(number), block, Access::kOverwrite);
        for (std::size_t i = 0; i < kContextBlockBytes; ++i)
          pinned.bytes()[i] = value(number, block, i);
      }
    pager.flush();
    log.reads.clear();
  }

  Log log;
  std::array<LevelFile, kLevels> files;
};

struct ContextFixture {
  ContextFixture(std::uint64_t frames, int io_threads, bool by_first_block = false)
      : pager(frames * kContextBlockBytes, io_threads) {
    levels.log.by_first_block = by_first_block;
    Pager maker(64 * kContextBlockBytes, 0);
    levels.attach(maker);
    levels.fill(maker, EvictionPolicy::kLayoutOrder);
    levels.detach(maker);
    levels.attach(pager);
  }
  ~ContextFixture() { levels.detach(pager); }
  ContextFixture(const ContextFixture&) = delete;
  ContextFixture& operator=(const ContextFixture&) = delete;
  const LevelFile& level(int number) { return levels.at(number); }

  Levels levels;
  Pager pager;
};

/// Holds the first transfer of block 0 of a level in one direction until it is let go.
class HeldTransfer {
 public:
  HeldTransfer(Log& log, Transfer::Direction direction, int of_level = 2) {
    log.before = [this, direction, of_level](int level, const Transfer& transfer) {
      if (level != of_level || transfer.block != 0 || transfer.direction != direction) return;
      if (was_begun_.exchange(true)) return;
      begun_.set_value();
      let_go_.get_future().wait();
    };
  }
  void wait_until_begun() { begun_.get_future().wait(); }
  void let_go() { let_go_.set_value(); }

 private:
  std::atomic<bool> was_begun_ = false;
  std::promise<void> begun_, let_go_;
};

/// Three frames hold a block 0, which is on its way, the block that it is coded by, and another one
/// that is pinned. A fourth block must wait for the transfer.
void check_that_a_fourth_block_waits(ContextFixture& f, Session& session, HeldTransfer& held) {
  held.wait_until_begun();
  const PinnedBlock other = session.pin(f.level(1), 1);
  auto fourth = std::async(std::launch::async,
                           [&] { return holds_its_values(session.pin(f.level(2), 4), 2, 4); });
  CHECK(eventually(other_threads_sleep));
  CHECK(fourth.wait_for(std::chrono::seconds(0)) == std::future_status::timeout);
  held.let_go();
  CHECK(fourth.get());
}

}  // namespace

TEST_CASE("Context_BlockOfTheFinestLevel_IsDecodedByCoarserOnesThatAreReadBefore") {
  ContextFixture f(8, GENERATE(0, 1, 2));
  Session session = f.pager.open_session();
  CHECK(holds_its_values(session.pin(f.level(3), 21), 3, 21));
  REQUIRE(f.levels.log.reads.size() == 3);
  for (int number = 1; number <= kLevels; ++number) {
    const ContextBlock& read = f.levels.log.reads[static_cast<std::size_t>(number - 1)];
    CHECK(read.level == number);
    CHECK(read.block == 21u >> 2 * (kLevels - number));
  }
  // What is resident already is not read again.
  CHECK(holds_its_values(session.pin(f.level(3), 22), 3, 22));
  CHECK(f.levels.log.reads.size() == 4);
}

TEST_CASE("Context_WrittenBlocks_AreEncodedByWhatTheyNeedWhateverIsEvicted") {
  const int io_threads = GENERATE(0, 1, 2);
  const auto policy = GENERATE(EvictionPolicy::kLayoutOrder, EvictionPolicy::kClock);
  Levels levels;
  Pager pager(3 * kContextBlockBytes, io_threads);
  levels.attach(pager);
  levels.fill(pager, policy);
  CHECK(levels.stored(2, 5)[0] == (value(2, 5, 0) ^ value(1, 1, 0)));
  CHECK(levels.stored(3, 21)[100] == (value(3, 21, 100) ^ value(2, 5, 100)));
  Session session = pager.open_session({.policy = policy});
  {
    const PinnedBlock pinned = session.pin(levels.at(3), 9, Access::kUpdate);
    CHECK(holds_its_values(pinned, 3, 9));
    pinned.bytes()[0] = std::byte{99};
  }
  for (std::uint64_t block = 16; block < 32; ++block)
    CHECK(holds_its_values(session.pin(levels.at(3), block, Access::kRead), 3, block));
  CHECK(session.pin(levels.at(3), 9, Access::kRead).bytes()[0] == std::byte{99});
  CHECK(pager.statistics().peak_frame_bytes <= 3 * kContextBlockBytes);
  levels.detach(pager);
}

TEST_CASE("Context_Bound_IsABlockAndOneOfEachCoarserLevel") {
  for (const std::uint64_t frames : {1u, 2u, 3u}) {
    ContextFixture f(frames, 1);
    Session session = f.pager.open_session();
    for (int number = 1; number <= kLevels; ++number) {
      const bool fits = static_cast<std::uint64_t>(number) <= frames;
      CAPTURE(frames, number);
      std::string message;
      try {
        const PinnedBlock pinned = session.pin(f.level(number), 1);
        CHECK(holds_its_values(pinned, number, 1));
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kBudget);
        message = error.what();
      }
      const std::string refusal = "page in difference" + std::to_string(number) + ": at least " +
                                  std::to_string((frames + 1) * kContextBlockBytes) + " bytes";
      CHECK(message.substr(0, refusal.size()) == (fits ? "" : refusal));
    }
    CHECK(f.pager.statistics().peak_frame_bytes <= frames * kContextBlockBytes);
  }
}

TEST_CASE("ContextWindow_BlockFarBehindThatTheNextOnesNeed_IsReadOnce") {
  const int io_threads = GENERATE(0, 1);
  const bool announced = GENERATE(false, true);
  ContextFixture f(8, io_threads, true);
  Session session = f.pager.open_session({.policy = EvictionPolicy::kLayoutOrder});
  const std::uint64_t count = f.levels.at(3).geometry.block_count();
  for (std::uint64_t block = 0; block < count; ++block) {
    CHECK(holds_its_values(session.pin(f.levels.at(3), block, Access::kRead), 3, block));
    if (announced && block + 1 < count) session.prefetch(f.levels.at(3), block + 1);
  }
  CHECK(f.levels.log.reads.size() == count + 2);
}

TEST_CASE("ContextWindow_BlockThatNoOtherNeedsAnyMore_LeavesBeforeThoseThatPassed") {
  ContextFixture f(8, 0);
  Session session = f.pager.open_session({.policy = EvictionPolicy::kLayoutOrder});
  // These 16 blocks need 4 of level 2, and 1 of level 1.
  for (std::uint64_t block = 0; block < 16; ++block) session.pin(f.level(3), block);
  CHECK(f.levels.log.reads.size() == 16 + 4 + 1);
  f.levels.log.reads.clear();
  for (std::uint64_t block = 11; block < 16; ++block)
    CHECK(holds_its_values(session.pin(f.level(3), block), 3, block));
  CHECK(f.levels.log.reads.empty());
}

TEST_CASE("ContextPrefetch_AskedAgain_ReadsCoarserBlocksFirst") {
  ContextFixture f(8, 1);
  Session session = f.pager.open_session();
  int asked = 0;
  while (!session.prefetch(f.level(3), 30)) {
    REQUIRE(++asked < 1'000'000);
    std::this_thread::yield();
  }
  CHECK(asked >= 2);  // once for each coarser level
  CHECK(holds_its_values(session.pin(f.level(3), 30), 3, 30));
  REQUIRE(f.levels.log.reads.size() == 3);
  CHECK(f.levels.log.reads[0].level == 1);
  CHECK(f.levels.log.reads[2].level == 3);
  CHECK(session.statistics().blocks_prefetched == 3);
}

TEST_CASE("ContextPrefetch_WhileItIsRead_KeepsWhatItIsCodedBy") {
  ContextFixture f(3, 1);
  Session session = f.pager.open_session();
  session.pin(f.level(1), 0);
  HeldTransfer held(f.levels.log, Transfer::Direction::kRead);
  REQUIRE(session.prefetch(f.level(2), 0));
  check_that_a_fourth_block_waits(f, session, held);
  CHECK(holds_its_values(session.pin(f.level(2), 0), 2, 0));
}

TEST_CASE("ContextPrefetch_WhileWhatItIsCodedByIsRead_DoesNotBegin") {
  ContextFixture f(8, 2);
  Session session = f.pager.open_session();
  session.pin(f.level(1), 0);
  HeldTransfer held(f.levels.log, Transfer::Direction::kRead);
  REQUIRE(session.prefetch(f.level(2), 0));
  held.wait_until_begun();
  CHECK_FALSE(session.prefetch(f.level(3), 0));
  held.let_go();
  CHECK(holds_its_values(session.pin(f.level(3), 0), 3, 0));
}

TEST_CASE("ContextPin_WhileTheCoarsestBlockIsRead_WaitsForItAndEnds") {
  ContextFixture f(8, 2);
  Session ahead = f.pager.open_session(), session = f.pager.open_session();
  HeldTransfer held(f.levels.log, Transfer::Direction::kRead, 1);
  REQUIRE(ahead.prefetch(f.level(1), 0));
  held.wait_until_begun();
  // The pin can begin no read: each block of its own waits for a coarser one, and the coarsest is
  // being read already.
  auto pinned = std::async(std::launch::async,
                           [&] { return holds_its_values(session.pin(f.level(3), 0), 3, 0); });
  CHECK(eventually(other_threads_sleep));
  CHECK(pinned.wait_for(std::chrono::seconds(0)) == std::future_status::timeout);
  held.let_go();
  CHECK(pinned.get());
}

TEST_CASE("ContextPin_OfSeveralBlocks_ReadsOneWhileAnotherTakesLong") {
  ContextFixture f(16, 2);
  Session session = f.pager.open_session();
  HeldTransfer held(f.levels.log, Transfer::Direction::kRead, 2);
  constexpr std::uint64_t kOther = 31;
  auto pinned = std::async(std::launch::async, [&] {
    const std::vector<BlockRequest> requests = {{f.level(3), 0}, {f.level(3), kOther}};
    std::vector<PinnedBlock> both(2);
    session.pin_many(requests, both);
    return holds_its_values(both[0], 3, 0) && holds_its_values(both[1], 3, kOther);
  });
  held.wait_until_begun();
  const auto other_is_read = [&] {
    const std::lock_guard lock(f.levels.log.mutex);
    return std::ranges::any_of(f.levels.log.reads, [](const ContextBlock& read) {
      return read.level == 3 && read.block == kOther;
    });
  };
  CHECK(eventually(other_is_read));
  held.let_go();
  CHECK(pinned.get());
}

TEST_CASE("ContextPrefetch_WithoutRoom_HoldsNothing") {
  ContextFixture f(2, 1);
  Session session = f.pager.open_session();
  session.pin(f.level(1), 0);
  {
    const PinnedBlock other = session.pin(f.level(1), 1);
    CHECK_FALSE(session.prefetch(f.level(2), 0));
  }
  CHECK(holds_its_values(session.pin(f.level(2), 4), 2, 4));
}

TEST_CASE("Context_WhileABlockIsWritten_IsKept") {
  ContextFixture f(3, GENERATE(0, 1));
  Session session = f.pager.open_session();
  HeldTransfer held(f.levels.log, Transfer::Direction::kWrite, 3);
  session.pin(f.levels.at(3), 0, Access::kUpdate).bytes()[0] = std::byte{99};
  auto flushed = std::async(std::launch::async, [&] { f.pager.flush(); });
  check_that_a_fourth_block_waits(f, session, held);
  flushed.get();
  CHECK(f.levels.stored(3, 0)[0] == (std::byte{99} ^ value(2, 0, 0)));
}

TEST_CASE("Context_CoarserBlockThatIsDamaged_FailsThePinAndLeavesNothing") {
  ContextFixture f(3, GENERATE(0, 1));
  Session session = f.pager.open_session();
  f.levels.stored(1, 0)[7] ^= std::byte{1};
  for (const Access access : {Access::kRead, Access::kUpdate, Access::kOverwrite})
    CHECK(code_of([&] { session.pin(f.levels.at(3), 4, access); }) == ErrorCode::kCorruption);
  f.levels.stored(1, 0)[7] ^= std::byte{1};
  f.pager.flush();
  CHECK(session.statistics().blocks_written == 0);
  for (std::uint64_t block = 0; block < 32; ++block)
    CHECK(holds_its_values(session.pin(f.level(3), block), 3, block));
}

TEST_CASE("Context_LevelThatOthersWereEncodedFrom_CannotBeChanged") {
  ContextFixture f(8, GENERATE(0, 1));
  Session session = f.pager.open_session();
  for (const Access access : {Access::kOverwrite, Access::kUpdate})
    for (const int fixed : {1, 2}) {
      CHECK(code_of([&] { session.pin(f.levels.at(fixed), 0, access); }) == ErrorCode::kBadState);
      // Also a block that is in memory.
      const PinnedBlock read = session.pin(f.level(fixed), 0);
      CHECK(code_of([&] { session.pin(f.levels.at(fixed), 0, access); }) == ErrorCode::kBadState);
      UnfinishedLevels pass;
      CHECK(code_of([&] { pass.add(f.levels.at(fixed), access); }) == ErrorCode::kBadState);
      CHECK(f.levels.at(fixed).is_finished());
    }
  session.pin(f.levels.at(3), 0, Access::kUpdate).bytes()[0] = std::byte{99};
  f.pager.flush();
  CHECK(f.levels.stored(3, 0)[0] == (std::byte{99} ^ value(2, 0, 0)));
}

namespace {

/// Levels that were never written, for a pager of their own.
struct NewLevels {
  explicit NewLevels(int io_threads) : pager(8 * kContextBlockBytes, io_threads) {
    levels.attach(pager);
  }
  ~NewLevels() { levels.detach(pager); }
  NewLevels(const NewLevels&) = delete;
  NewLevels& operator=(const NewLevels&) = delete;

  Levels levels;
  Pager pager;
};

}  // namespace

TEST_CASE("Context_BlockThatIsBeingChanged_CannotBeEncodedFrom") {
  NewLevels f(GENERATE(0, 1));
  Session session = f.pager.open_session();
  const PinnedBlock coarse = session.pin(f.levels.at(1), 0, Access::kOverwrite);
  CHECK(code_of([&] { session.pin(f.levels.at(2), 0, Access::kOverwrite); }) ==
        ErrorCode::kBadState);
  CHECK_FALSE(f.levels.at(1).is_fixed);
  std::vector<PinnedBlock> pinned(2);
  const std::vector<BlockRequest> both{{f.levels.at(2), 4, Access::kOverwrite},
                                       {f.levels.at(1), 1, Access::kOverwrite}};
  CHECK(code_of([&] { session.pin_many(both, pinned); }) == ErrorCode::kBadState);
}

TEST_CASE("Context_BlockThatWasChanged_IsWrittenBeforeOthersAreEncodedFromIt") {
  NewLevels f(GENERATE(0, 1));
  Session session = f.pager.open_session();
  session.pin(f.levels.at(1), 0, Access::kOverwrite).bytes()[0] = std::byte{3};
  {
    const PinnedBlock fine = session.pin(f.levels.at(2), 0, Access::kOverwrite);
    CHECK(f.levels.stored(1, 0)[0] == std::byte{3});
    CHECK(f.levels.at(1).is_fixed);
    fine.bytes()[0] = std::byte{5};
  }
  f.pager.flush();
  CHECK(f.levels.stored(2, 0)[0] == (std::byte{3} ^ std::byte{5}));
}

TEST_CASE("Context_BlockThatDoesNotComeEarlier_IsRefused") {
  ContextFixture f(3, 0);
  Session session = f.pager.open_session();
  f.levels.log.misnamed = true;
  CHECK(code_of([&] { session.pin(f.level(2), 4); }) == ErrorCode::kBadState);
  f.levels.log.misnamed = false;
  CHECK(holds_its_values(session.pin(f.level(2), 4), 2, 4));
}

TEST_CASE("Context_ManyThreadsAndSessions_NeverWaitForEachOtherForGood") {
  const int io_threads = GENERATE(0, 2);
  ContextFixture f(9, io_threads);
  std::atomic<int> wrong = 0, refused = 0;
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 6; ++seed)
    threads.emplace_back([&, seed] {
      std::mt19937 random(seed);
      Session session = f.pager.open_session(
          {.policy = seed % 2 == 0 ? EvictionPolicy::kLayoutOrder : EvictionPolicy::kClock});
      for (int step = 0; step < 400; ++step) {
        const int number = 1 + static_cast<int>(random() % kLevels);
        const std::uint64_t count = f.level(number).geometry.block_count();
        const std::uint64_t block = random() % count, other = random() % count;
        if (step % 5 == 0) session.prefetch(f.level(number), other);
        const std::array requests{BlockRequest(f.level(number), block),
                                  BlockRequest(f.level(number), other)};
        std::array<PinnedBlock, 2> pinned;
        try {
          session.pin_many(requests, pinned);
          if (!holds_its_values(pinned[0], number, block) ||
              !holds_its_values(pinned[1], number, other))
            ++wrong;
        } catch (const Error& error) {
          ++(error.code() == ErrorCode::kBudget ? refused : wrong);
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(refused == 0);  // each holds what one call pins, and nothing while it asks
}
