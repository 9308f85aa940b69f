// The pager under eight threads, over every backend: pins, updates, overwrites, prefetches,
// abandoned blocks and transfers that fail, at random. Worth most under the thread sanitizer.
#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <mutex>
#include <optional>
#include <random>
#include <shared_mutex>
#include <thread>
#include <vector>

#include "durability/faults.h"
#include "plait/error.h"
#include "plait/pager.h"
#include "support/counting_backend.h"
#include "support/journaled_volume.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBlockBytes = 4096, kBlocks = 48, kThreads = 8;
constexpr int kSteps = 200;
constexpr unsigned char kHalfWritten = 0xee;

struct Faults {
  std::atomic<bool> reads = false, writes = false;
  std::atomic<unsigned> count = 0;
};

/// One transfer in eleven fails while it should.
class UnreliableBackend final : public ForwardingBackend {
 public:
  UnreliableBackend(std::unique_ptr<Backend> inner, Faults& faults)
      : ForwardingBackend(std::move(inner)), faults_(faults) {}
  void read(BlockRange blocks, std::span<std::byte> into) override {
    if (fails(faults_.reads)) throw Error(ErrorCode::kIo, "unreliable: read");
    inner().read(blocks, into);
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (fails(faults_.writes)) throw Error(ErrorCode::kNoSpace, "unreliable: write");
    inner().write(blocks, from);
  }
  void start(Transfer& transfer) noexcept override {
    const bool read = transfer.direction == Transfer::Direction::kRead;
    if (!fails(read ? faults_.reads : faults_.writes)) return inner().start(transfer);
    transfer.listener->finished(
        transfer, std::make_exception_ptr(Error(read ? ErrorCode::kIo : ErrorCode::kNoSpace,
                                                read ? "unreliable: read" : "unreliable: write")));
  }

 private:
  bool fails(const std::atomic<bool>& when) { return when && ++faults_.count % 11 == 0; }
  Faults& faults_;
};

/// A level in a store of its own, every block of which holds one value over and over.
class Stress {
 public:
  Stress(const BackendRegistry::Entry& entry, EvictionPolicy policy, int io_threads)
      : entry_(entry), pager_(30 * kBlockBytes, io_threads) {
    session_ = pager_.open_session(
        {.policy = policy,
         .window_bytes = policy == EvictionPolicy::kWindow ? 16 * kBlockBytes : 0});
    file_.geometry = LevelGeometry(kBlocks * kBlockBytes, {}, BaseRelativeLevel(1), 1, kBlockBytes);
    file_.table = BlockTable({}, 2, 1, kBlocks);
    if (entry.traits.durable) directory_ = Directory(place_.path());
    open(OpenMode::kCreate);
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      fill(session_.pin(file_, block, Access::kWrite), 0, kBlockBytes);
    pager_.flush();
    volume_->begin_version(2);
  }
  ~Stress() {
    pager_.discard();
    pager_.detach(file_);
  }
  Stress(const Stress&) = delete;
  Stress& operator=(const Stress&) = delete;

  void open(OpenMode mode) {
    pager_.detach(file_);
    file_.backend.reset();
    BackendOptions options;
    options.codec = "lz4";
    volume_ = wrapped_volume(entry_.open, [this](Volume& inner, const LevelSpec& level) {
      return std::make_unique<UnreliableBackend>(inner.open_level(level), faults_);
    })({options, 8 * kBlockBytes, 2});
    file_.traits = entry_.traits;
    file_.writable = mode != OpenMode::kRead;
    file_.backend = volume_->open_level(
        LevelSpec{directory_, "attribute2.level01", mode, file_.geometry, file_.table, 1});
    pager_.attach(file_);
  }

  void run(bool writing) {
    std::vector<std::thread> threads;
    for (std::uint32_t number = 0; number < kThreads; ++number)
      threads.emplace_back([this, number, writing] { work(number + 1, writing); });
    for (std::thread& thread : threads) thread.join();
  }

  /// Whether all blocks hold what was last stored.
  bool holds_all() {
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      if (value_of(session_.pin(file_, block, Access::kRead)) != expected_[block]) return false;
    return true;
  }

  Pager& pager() { return pager_; }
  LevelFile& file() { return file_; }
  Faults& faults() { return faults_; }
  /// Values that nobody stored, and errors that nobody made.
  std::atomic<int> wrong = 0;

 private:
  static void fill(const PinnedBlock& pinned, unsigned char value, std::size_t bytes) {
    std::memset(pinned.bytes().data(), value, bytes);
  }
  static std::optional<unsigned char> value_of(const PinnedBlock& pinned) {
    const std::byte first = pinned.bytes()[0];
    if (std::ranges::any_of(pinned.bytes(), [&](std::byte byte) { return byte != first; }))
      return std::nullopt;
    return static_cast<unsigned char>(first);
  }

  /// Nothing if it failed for a reason that there is.
  PinnedBlock try_pin(std::uint64_t block, Access access) {
    try {
      return session_.pin(file_, block, access);
    } catch (const Error& error) {
      const bool allowed = error.code() == ErrorCode::kIo
                               ? faults_.reads.load()
                               : faults_.writes && (error.code() == ErrorCode::kNoSpace ||
                                                    error.code() == ErrorCode::kBadState);
      if (!allowed) ++wrong;
      return {};
    }
  }

  void read(std::uint64_t block, std::uint64_t other) {
    if (block > other) std::swap(block, other);
    const std::shared_lock lock(mutexes_[block]);
    std::shared_lock<std::shared_mutex> other_lock;
    if (other != block) other_lock = std::shared_lock(mutexes_[other]);
    const PinnedBlock first = try_pin(block, Access::kRead);
    const PinnedBlock second = try_pin(other, Access::kRead);
    if (first && value_of(first) != expected_[block]) ++wrong;
    if (second && value_of(second) != expected_[other]) ++wrong;
  }

  void store(std::uint64_t block, Access access, unsigned char value) {
    const std::unique_lock lock(mutexes_[block]);
    const PinnedBlock pinned = try_pin(block, access);
    if (!pinned) return;
    if (access == Access::kUpdate && value_of(pinned) != expected_[block]) ++wrong;
    fill(pinned, value, kBlockBytes);
    expected_[block] = value;
  }

  /// What is there then is older, and whole. A level in memory has what was stored.
  void abandon(std::uint64_t block, Access access) {
    if (entry_.traits.in_memory) return;
    const std::unique_lock lock(mutexes_[block]);
    PinnedBlock pinned = try_pin(block, access);
    if (!pinned) return;
    fill(pinned, kHalfWritten, kBlockBytes / 2);
    pinned.abandon();
    while (!(pinned = try_pin(block, Access::kRead)))
      if (wrong > 0) return;
    const std::optional<unsigned char> found = value_of(pinned);
    if (!found || *found == kHalfWritten) ++wrong;
    expected_[block] = found.value_or(0);
  }

  void work(std::uint32_t seed, bool writing) {
    std::mt19937 random(seed);
    for (int step = 0; step < kSteps; ++step) {
      const std::uint64_t block = random() % kBlocks, other = random() % kBlocks;
      const auto value = static_cast<unsigned char>(random() % kHalfWritten);
      const auto access = random() % 2 == 0 ? Access::kUpdate : Access::kWrite;
      const auto what = random() % 10;
      if (what < 2)
        session_.prefetch(file_, block);
      else if (what < 6 || !writing)
        read(block, other);
      else if (what < 9)
        store(block, access, value);
      else
        abandon(block, access);
    }
  }

  const BackendRegistry::Entry entry_;
  TemporaryDirectory place_{Medium::kMemory};
  Directory directory_;
  Faults faults_;
  std::unique_ptr<Volume> volume_;
  LevelFile file_;
  Pager pager_;
  Session session_;
  std::array<std::shared_mutex, kBlocks> mutexes_;  ///< whoever stores is alone at its block
  std::array<unsigned char, kBlocks> expected_{};
};

std::vector<std::pair<std::string, BackendRegistry::Entry>> subjects() {
  std::vector<std::pair<std::string, BackendRegistry::Entry>> result;
  for (const std::string& name : usable_backends()) {
    const BackendRegistry::Entry& entry = default_backends().find(name);
    result.emplace_back(name, entry);
    if (entry.traits.overwrites_in_place)
      result.emplace_back(name + " (journaled)", journaled(entry));
  }
  return result;
}

template <class Check>
void for_each_case(Check check) {
  const NoWaiting no_waiting;
  for (const auto& [name, entry] : subjects())
    for (const EvictionPolicy policy : {EvictionPolicy::kWindow, EvictionPolicy::kClock})
      for (const int io_threads : {0, 2}) {
        CAPTURE(name, policy, io_threads);
        Stress stress(entry, policy, io_threads);
        check(stress, entry);
      }
}

}  // namespace

TEST_CASE("PagerStress_EightThreads_ServeWhatWasStored") {
  for_each_case([](Stress& stress, const BackendRegistry::Entry& entry) {
    stress.run(true);
    CHECK(stress.wrong == 0);
    stress.pager().flush();
    CHECK(stress.holds_all());
    CHECK(stress.file().is_finished() == entry.traits.in_memory);
    CHECK(stress.pager().statistics().peak_frame_bytes <= stress.pager().budget_bytes());
    if (!entry.traits.durable) return;
    stress.open(OpenMode::kRead);
    stress.run(false);
    CHECK(stress.wrong == 0);
    CHECK(stress.holds_all());
  });
}

TEST_CASE("PagerStress_ReadsThatFail_FailTheirPinsAndNoOthers") {
  for_each_case([](Stress& stress, const BackendRegistry::Entry& entry) {
    stress.faults().reads = true;
    stress.run(true);
    stress.faults().reads = false;
    CHECK(stress.wrong == 0);
    stress.pager().flush();
    CHECK(stress.holds_all());
    if (!entry.traits.durable) return;
    stress.open(OpenMode::kRead);
    CHECK(stress.holds_all());
  });
}

TEST_CASE("PagerStress_WritesThatFail_LoseNothingThatIsInMemory") {
  for_each_case([](Stress& stress, const BackendRegistry::Entry&) {
    stress.faults().writes = true;
    stress.run(true);
    CHECK(stress.wrong == 0);
    CHECK(stress.holds_all());
  });
}

}  // namespace plait::test
