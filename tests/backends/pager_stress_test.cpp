// The pager under eight threads in five sessions, over every backend: pins of
// one block and of several, updates, overwrites, prefetches, abandoned blocks and transfers that
// fail, at random, with room for all and without. Worth most under the thread sanitizer.
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
#include "plait/extend/pager.h"
#include "support/counting_backend.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kStressBlockBytes = 4096, kBlocks = 48, kStressThreads = 8;
constexpr int kSteps = unless_sanitized(200, 15);
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

/// Which policies the sessions have.
enum class Policies : std::uint8_t { kLayoutOrder, kClock, kBoth };

/// A level in a store of its own, every block of which holds one value over and over.
class Stress {
 public:
  /// `frames`: all threads together hold at most 24 at once.
  Stress(const RegisteredBackend& entry, Policies policies, int io_threads, std::uint64_t frames)
      : entry_(entry), pager_(frames * kStressBlockBytes, io_threads), tight_(frames < 24) {
    for (std::size_t i = 0; i < sessions_.size(); ++i) {
      const bool window =
          policies == Policies::kLayoutOrder || (policies == Policies::kBoth && i % 2 == 0);
      sessions_[i] = pager_.open_session(
          {.policy = window ? EvictionPolicy::kLayoutOrder : EvictionPolicy::kClock,
           .share_bytes = i < 2 ? 4 * kStressBlockBytes : 0,
           .window_bytes = window ? 2 * kStressBlockBytes : 0});
    }
    file_.geometry = LevelGeometry(SlotShapes(kBlocks * kStressBlockBytes), BaseRelativeLevel(1), 1,
                                   kStressBlockBytes);
    file_.table = BlockTable({}, 2, 1, kBlocks);
    if (entry.traits.durable) directory_ = Directory(place_.path());
    open(OpenMode::kCreate);
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      fill(sessions_[0].pin(file_, block, Access::kOverwrite), 0, kStressBlockBytes);
    pager_.flush();
    volume_->begin_version(2, {});
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
    volume_ = wrapped_volume(entry_.open, [this](Volume& inner, const LevelSpec& level) {
      return std::make_unique<UnreliableBackend>(inner.open_level(level), faults_);
    })({8 * kStressBlockBytes, 2});
    file_.traits = entry_.traits;
    file_.writable = mode != OpenMode::kRead;
    const AttributeSchema schema{"bytes", ComponentType::kUint8, 1};
    file_.backend =
        volume_->open_level({directory_, "attribute2.level01.1", mode, file_.geometry, file_.table,
                             schema, entry_.traits.compressed ? "lz4" : "none"});
    pager_.attach(file_);
  }

  void run(bool writing) {
    std::vector<std::thread> threads;
    for (std::uint32_t number = 0; number < kStressThreads; ++number)
      threads.emplace_back([this, number, writing] {
        // The last four share a session.
        Worker(*this, sessions_[std::min<std::size_t>(number, sessions_.size() - 1)], number + 1)
            .work(writing);
      });
    for (std::thread& thread : threads) thread.join();
  }

  /// Whether all blocks hold what was last stored.
  bool holds_all() {
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      if (value_of(sessions_[0].pin(file_, block, Access::kRead)) != expected_[block]) return false;
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

  /// Whether the error has a reason.
  bool is_allowed(ErrorCode code) const {
    if (code == ErrorCode::kBudget) return tight_;
    if (code == ErrorCode::kIo) return faults_.reads;
    return faults_.writes && (code == ErrorCode::kNoSpace || code == ErrorCode::kBadState);
  }

  /// What one thread does. It holds no pin while it waits for a block's mutex.
  class Worker {
   public:
    Worker(Stress& stress, Session& session, std::uint32_t seed)
        : stress_(stress), session_(session), random_(seed) {}

    void work(bool writing) {
      for (int step = 0; step < kSteps; ++step) {
        const std::uint64_t block = random_() % kBlocks, other = random_() % kBlocks;
        const auto value = static_cast<unsigned char>(random_() % kHalfWritten);
        const auto access = random_() % 2 == 0 ? Access::kUpdate : Access::kOverwrite;
        const auto what = random_() % 12;
        if (what < 2)
          session_.prefetch(stress_.file_, block);
        else if (what < 4)
          read(block, other);
        else if (what < 8 || !writing)
          read_at_once(block, other);
        else if (what < 11)
          store(block, access, value);
        else
          abandon(block, access);
      }
    }

   private:
    /// Nothing if it failed for a reason that there is.
    PinnedBlock try_pin(std::uint64_t block, Access access) {
      try {
        return session_.pin(stress_.file_, block, access);
      } catch (const Error& error) {
        if (!stress_.is_allowed(error.code())) ++stress_.wrong;
        return {};
      }
    }
    void check(const PinnedBlock& pinned, std::uint64_t block) {
      if (pinned && value_of(pinned) != stress_.expected_[block]) ++stress_.wrong;
    }
    template <class Use>
    void with_both(std::uint64_t block, std::uint64_t other, Use use) {
      if (block > other) std::swap(block, other);
      const std::shared_lock lock(stress_.mutexes_[block]);
      std::shared_lock<std::shared_mutex> other_lock;
      if (other != block) other_lock = std::shared_lock(stress_.mutexes_[other]);
      use(block, other);
    }

    void read(std::uint64_t one, std::uint64_t two) {
      with_both(one, two, [&](std::uint64_t block, std::uint64_t other) {
        const PinnedBlock first = try_pin(block, Access::kRead);
        const PinnedBlock second = try_pin(other, Access::kRead);
        check(first, block);
        check(second, other);
      });
    }
    void read_at_once(std::uint64_t one, std::uint64_t two) {
      with_both(one, two, [&](std::uint64_t block, std::uint64_t other) {
        const LevelFile& file = stress_.file_;
        const std::array requests{BlockRequest(file, block), BlockRequest(file, other),
                                  BlockRequest(file, block)};
        std::array<PinnedBlock, 3> pinned;
        try {
          session_.pin_many(requests, pinned);
        } catch (const Error& error) {
          if (!stress_.is_allowed(error.code())) ++stress_.wrong;
        }
        for (std::size_t i = 0; i < requests.size(); ++i) check(pinned[i], requests[i].block());
      });
    }
    void store(std::uint64_t block, Access access, unsigned char value) {
      const std::unique_lock lock(stress_.mutexes_[block]);
      const PinnedBlock pinned = try_pin(block, access);
      if (!pinned) return;
      if (access == Access::kUpdate) check(pinned, block);
      fill(pinned, value, kStressBlockBytes);
      stress_.expected_[block] = value;
    }
    /// What is there then is older, and whole. A level in memory has what was stored.
    void abandon(std::uint64_t block, Access access) {
      if (stress_.entry_.traits.in_memory) return;
      const std::unique_lock lock(stress_.mutexes_[block]);
      PinnedBlock pinned = try_pin(block, access);
      if (!pinned) return;
      fill(pinned, kHalfWritten, kStressBlockBytes / 2);
      pinned.abandon();
      while (!(pinned = try_pin(block, Access::kRead)))
        if (stress_.wrong > 0) return;
      const std::optional<unsigned char> found = value_of(pinned);
      if (!found || *found == kHalfWritten) ++stress_.wrong;
      stress_.expected_[block] = found.value_or(0);
    }

    Stress& stress_;
    Session& session_;
    std::mt19937 random_;
  };

  const RegisteredBackend entry_;
  TemporaryDirectory place_{Medium::kMemory};
  Directory directory_;
  Faults faults_;
  std::unique_ptr<Volume> volume_;
  LevelFile file_;
  Pager pager_;
  const bool tight_;  ///< threads may find no room
  std::array<Session, 5> sessions_;
  std::array<std::shared_mutex, kBlocks> mutexes_;  ///< whoever stores is alone at its block
  std::array<unsigned char, kBlocks> expected_{};
};

std::vector<std::pair<std::string, RegisteredBackend>> subjects() {
  std::vector<std::pair<std::string, RegisteredBackend>> result;
  for (const std::string& name : usable_backends()) {
    const RegisteredBackend& entry = default_backends().find(name);
    result.emplace_back(name, entry);
  }
  return result;
}

template <class Check>
void for_each_case(Check check) {
  const NoWaiting no_waiting;
  for (const auto& [name, entry] : subjects())
    for (const Policies policies : {Policies::kLayoutOrder, Policies::kClock, Policies::kBoth})
      for (const int io_threads : {0, 2})
        for (const std::uint64_t frames : {30u, 9u}) {
          if (unless_sanitized(false, true) && (io_threads == 0) == (frames == 9)) continue;
          CAPTURE(name, policies, io_threads, frames);
          Stress stress(entry, policies, io_threads, frames);
          check(stress, entry);
        }
}

}  // namespace

TEST_CASE("PagerStress_EightThreads_ServeWhatWasStored") {
  for_each_case([](Stress& stress, const RegisteredBackend& entry) {
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
  for_each_case([](Stress& stress, const RegisteredBackend& entry) {
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
  for_each_case([](Stress& stress, const RegisteredBackend&) {
    stress.faults().writes = true;
    stress.run(true);
    CHECK(stress.wrong == 0);
    CHECK(stress.holds_all());
  });
}

}  // namespace plait::test
