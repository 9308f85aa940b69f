// Which blocks the pager moves together: adjacent ones of one run, in whatever order they were
// asked for. The backend here keeps what it was handed over.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <vector>

#include "base/caught.h"
#include "paging/level_cursor.h"
#include "plait/error.h"
#include "plait/extend/pager.h"
#include "support/error_of.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kKeptBlockBytes = 65536, kBlocksOfRun = kRunBytes / kKeptBlockBytes;
constexpr std::uint64_t kBadBlock = 21;

struct Call {
  Transfer::Direction direction;
  BlockRange blocks;
};

class KeepingCalls final : public Backend {
 public:
  explicit KeepingCalls(const LevelSpec& spec) : spec_(spec), bytes_(spec.geometry.total_bytes()) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    if (blocks.first == kBadBlock && bad) throw Error(ErrorCode::kIo, "read kept: a bad place");
    std::memcpy(into.data(), place(blocks.first), into.size());
    spec_.table.check(blocks.first, into, "kept");
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    std::memcpy(place(blocks.first), from.data(), from.size());
    const std::scoped_lock lock(mutex_);
    spec_.table.seal(blocks.first, spec_.geometry.block_offset(blocks.first), BlockEncoding::kRaw,
                     from);
  }
  void start(Transfer& transfer) noexcept override {
    keep(transfer, 1);
    Backend::start(transfer);
  }
  void start_run(std::span<Transfer* const> run) noexcept override {
    for (std::size_t i = 1; i < run.size(); ++i)
      adjacent =
          adjacent && run[i]->block == run[0]->block + i && run[i]->direction == run[0]->direction;
    keep(*run.front(), run.size());
    for (Transfer* const transfer : run) Backend::start(*transfer);
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return bytes_.size(); }

  std::vector<Call> take_calls() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(calls_, {});
  }
  std::atomic<bool> adjacent = true, bad = false;

 private:
  std::byte* place(std::uint64_t block) {
    return bytes_.data() + spec_.geometry.block_offset(block);
  }
  void keep(const Transfer& first, std::uint64_t count) {
    const std::scoped_lock lock(mutex_);
    calls_.push_back({first.direction, {first.block, count}});
  }
  LevelSpec spec_;
  std::vector<std::byte> bytes_;
  std::mutex mutex_;
  std::vector<Call> calls_;
};

/// A level of whole blocks, and a last one that is short.
struct KeptLevel {
  KeptLevel(Pager& its_pager, std::uint64_t blocks, bool moves_runs = true)
      : pager(its_pager), session(pager.open_session()) {
    constexpr std::uint64_t kSlots = 1024;  // of a block; a slot has one record
    file.geometry = LevelGeometry(SlotShapes((blocks - 1) * kSlots + kSlots / 4),
                                  BaseRelativeLevel(1), kKeptBlockBytes / kSlots, kKeptBlockBytes);
    file.table = BlockTable({}, 0, 1, file.geometry.block_count());
    auto made = std::make_unique<KeepingCalls>(
        LevelSpec{directory, "kept", OpenMode::kCreate, file.geometry, file.table, {}});
    backend = made.get();
    file.backend = std::move(made);
    file.traits.moves_runs = moves_runs;
    pager.attach(file);
    REQUIRE(file.geometry.block_count() == blocks);
  }
  ~KeptLevel() { pager.detach(file); }
  KeptLevel(const KeptLevel&) = delete;
  KeptLevel& operator=(const KeptLevel&) = delete;

  static std::byte value(std::uint64_t block) { return static_cast<std::byte>(block % 250 + 1); }
  /// Puts a block on the "disk", past the pager.
  void store(std::uint64_t block) {
    backend->write({block, 1},
                   std::vector<std::byte>(file.geometry.block_bytes(block), value(block)));
  }
  void put(std::uint64_t block) {
    const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
    std::ranges::fill(pinned.bytes(), value(block));
  }

  Directory directory;
  LevelFile file;
  KeepingCalls* backend = nullptr;
  Pager& pager;
  Session session;
};

/// The calls that move these blocks: as few as there can be.
std::size_t fewest_calls(std::vector<std::uint64_t> blocks) {
  std::ranges::sort(blocks);
  std::size_t calls = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (i == 0 || blocks[i] != blocks[i - 1] + 1 || blocks[i] % kBlocksOfRun == 0) ++calls;
  return calls;
}

/// How often each block was moved.
std::map<std::uint64_t, int> moved(const std::vector<Call>& calls, Transfer::Direction direction) {
  std::map<std::uint64_t, int> result;
  for (const Call& call : calls)
    for (std::uint64_t i = 0; call.direction == direction && i < call.blocks.count; ++i)
      ++result[call.blocks.first + i];
  return result;
}

}  // namespace

TEST_CASE("PagerPinMany_RandomBlocks_AreReadInAsFewCallsAsThereAreRuns") {
  constexpr std::uint64_t kBlocks = 5 * kBlocksOfRun + 7;
  std::mt19937 random(11);
  for (const int threads : {0, 1, 3}) {
    Pager pager(2 * kBlocks * kKeptBlockBytes, threads);
    for (int round = 0; round < 60; ++round) {
      KeptLevel level(pager, kBlocks);
      std::vector<std::uint64_t> wanted, stored;
      for (std::uint64_t block = 0; block < kBlocks; ++block) {
        const bool is_stored = random() % 8 != 0, is_wanted = random() % 3 != 0;
        if (is_stored) level.store(block);
        if (is_wanted) wanted.push_back(block);
        if (is_stored && is_wanted) stored.push_back(block);
      }
      std::ranges::shuffle(wanted, random);
      std::vector<BlockRequest> requests;
      for (const std::uint64_t block : wanted)
        requests.emplace_back(std::as_const(level.file), block);
      std::vector<PinnedBlock> pinned(requests.size());
      level.session.pin_many(requests, pinned);
      bool same = true;
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        const bool is_stored = std::ranges::find(stored, wanted[i]) != stored.end();
        same = same && pinned[i].bytes().size() == level.file.geometry.block_bytes(wanted[i]) &&
               pinned[i].bytes().back() == (is_stored ? KeptLevel::value(wanted[i]) : std::byte{0});
      }
      CHECK(same);
      const std::vector<Call> calls = level.backend->take_calls();
      CHECK(calls.size() == fewest_calls(stored));
      CHECK(moved(calls, Transfer::Direction::kRead).size() == stored.size());
      CHECK(level.backend->adjacent);
      pinned.clear();
    }
  }
}

TEST_CASE("PagerPinMany_BackendThatMovesNoRuns_ReadsBlockByBlock") {
  Pager pager(64 * kKeptBlockBytes, 1);
  KeptLevel level(pager, 20, false);
  std::vector<BlockRequest> requests;
  for (std::uint64_t block = 0; block < 20; ++block) {
    level.store(block);
    requests.emplace_back(std::as_const(level.file), block);
  }
  std::vector<PinnedBlock> pinned(requests.size());
  level.session.pin_many(requests, pinned);
  CHECK(level.backend->take_calls().size() == 20);
}

TEST_CASE("PagerPinMany_OneBadBlock_FailsThePinAndTheOthersCanBePinned") {
  Pager pager(64 * kKeptBlockBytes, 1);
  KeptLevel level(pager, 40);
  std::vector<BlockRequest> requests;
  for (std::uint64_t block = 0; block < 40; ++block) level.store(block);
  for (std::uint64_t block = 18; block < 26; ++block)
    requests.emplace_back(std::as_const(level.file), block);
  level.backend->bad = true;
  std::vector<PinnedBlock> pinned(requests.size());
  CHECK(code_of([&] { level.session.pin_many(requests, pinned); }) == ErrorCode::kIo);
  for (std::uint64_t block = 18; block < 26; ++block)
    if (block != kBadBlock)
      CHECK(level.session.pin(level.file, block, Access::kRead).bytes()[3] ==
            KeptLevel::value(block));
  level.backend->bad = false;
  CHECK(level.session.pin(level.file, kBadBlock, Access::kRead).bytes()[3] ==
        KeptLevel::value(kBadBlock));
}

TEST_CASE("PagerWriteBehind_BlocksInAnyOrder_GoOutByWholeRuns") {
  constexpr std::uint64_t kBlocks = 6 * kBlocksOfRun + 3;
  std::mt19937 random(3);
  for (const int order : {0, 1, 2}) {  // ascending, descending, shuffled
    Pager pager(16 * kBlocks * kKeptBlockBytes, 1);
    KeptLevel level(pager, kBlocks);
    std::vector<std::uint64_t> blocks(kBlocks);
    for (std::uint64_t block = 0; block < kBlocks; ++block) blocks[block] = block;
    if (order == 1) std::ranges::reverse(blocks);
    if (order == 2) std::ranges::shuffle(blocks, random);
    for (const std::uint64_t block : blocks) level.put(block);
    pager.wait_for_writes();
    const std::vector<Call> calls = level.backend->take_calls();
    CHECK(calls.size() == fewest_calls(blocks));
    CHECK(moved(calls, Transfer::Direction::kWrite).size() == kBlocks);
    CHECK(pager.statistics().blocks_written == kBlocks);
    CHECK(level.backend->adjacent);
  }
}

TEST_CASE("PagerFlush_PartsOfRuns_AreWrittenTogether") {
  for (const int threads : {0, 2}) {
    Pager pager(256 * kKeptBlockBytes, threads);
    KeptLevel level(pager, 64);
    const std::vector<std::uint64_t> blocks = {40, 3, 4, 41, 5, 15, 16, 17, 63};
    for (const std::uint64_t block : blocks) level.put(block);
    CHECK(level.backend->take_calls().empty());
    pager.flush();
    const std::vector<Call> calls = level.backend->take_calls();
    CHECK(calls.size() == fewest_calls(blocks));
    CHECK(calls.size() == 5);
    CHECK(moved(calls, Transfer::Direction::kWrite).size() == blocks.size());
  }
}

TEST_CASE("PagerWriteBehind_LittleMemory_WritesPartsOfRunsAndLosesNone") {
  constexpr std::uint64_t kBlocks = 4 * kBlocksOfRun;
  std::mt19937 random(9);
  for (const std::uint64_t frames : {2u, 3u, 9u, 40u}) {
    Pager pager(frames * kKeptBlockBytes, 1);
    KeptLevel level(pager, kBlocks);
    std::vector<std::uint64_t> blocks(kBlocks);
    for (std::uint64_t block = 0; block < kBlocks; ++block) blocks[block] = block;
    std::ranges::shuffle(blocks, random);
    for (const std::uint64_t block : blocks) level.put(block);
    pager.flush();
    const auto written = moved(level.backend->take_calls(), Transfer::Direction::kWrite);
    CHECK(written.size() == kBlocks);
    CHECK(std::ranges::all_of(written, [](const auto& each) { return each.second == 1; }));
    CHECK(pager.statistics().peak_frame_bytes <= frames * kKeptBlockBytes);
    bool same = true;
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      same = same && level.session.pin(level.file, block, Access::kRead).bytes()[9] ==
                         KeptLevel::value(block);
    CHECK(same);
  }
}

TEST_CASE("PagerWriteBehind_BlockThatWaitsForItsRun_CanBeChangedAgain") {
  Pager pager(256 * kKeptBlockBytes, 1);
  KeptLevel level(pager, 32);
  for (int times = 0; times < 3; ++times) level.put(5);
  CHECK(level.backend->take_calls().empty());
  pager.flush();
  CHECK(pager.statistics().blocks_written == 1);
  for (std::uint64_t block = 0; block < kBlocksOfRun; ++block) level.put(block);
  pager.wait_for_writes();
  CHECK(level.backend->take_calls().size() == 2);
}

TEST_CASE("LevelCursor_WholeLevel_ReadsItByRuns") {
  constexpr std::uint64_t kBlocks = 12 * kBlocksOfRun + 5;
  Pager pager(256 * kBlocksOfRun * kKeptBlockBytes, 1);
  KeptLevel level(pager, kBlocks);
  for (std::uint64_t block = 0; block < kBlocks; ++block) level.store(block);
  LevelCursor cursor(pager.open_session(), level.file);
  bool same = true;
  for (EdgeId edge = 0; edge < level.file.geometry.edge_count(); ++edge)
    same =
        same && cursor.slot(edge).bytes[0] == KeptLevel::value(level.file.geometry.block_of(edge));
  CHECK(same);
  const std::vector<Call> calls = level.backend->take_calls();
  CHECK(calls.size() == 13 + 1);  // the first block is read when it is needed
  CHECK(moved(calls, Transfer::Direction::kRead).size() == kBlocks);
}

}  // namespace plait::test
