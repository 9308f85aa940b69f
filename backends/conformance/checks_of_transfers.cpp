// Checks of Backend::start and start_run, by which the pager moves blocks: all blocks of a level on
// their way at once.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>

#include "conformance/suite.h"

namespace plait::conformance {
namespace {

/// A transfer that takes longer is taken for lost.
constexpr std::chrono::seconds kLongest(60);

/// Transfers of all blocks of a level, each with memory of its own, and how they ended.
class AllBlocks final : public TransferListener {
 public:
  AllBlocks(Backend& backend, const LevelGeometry& geometry, bool as_a_run)
      : backend_(backend),
        as_a_run_(as_a_run),
        memory_(geometry.block_count()),
        transfers_(geometry.block_count()) {
    for (std::uint32_t block = 0; block < transfers_.size(); ++block) {
      memory_[block].assign(geometry.block_bytes(block), std::byte{0xa5});
      transfers_[block].block = block;
      transfers_[block].memory = memory_[block];
      transfers_[block].listener = this;
      transfers_[block].tag = block;
    }
  }

  Bytes& memory(std::uint64_t block) { return memory_[block]; }
  /// Starts all transfers. With `then_read`, the listener of a block that was written starts to
  /// read it at once. Returns false if some have not ended in time.
  bool run(Transfer::Direction direction, bool then_read = false) {
    ended_.assign(transfers_.size(), 0);
    errors_.assign(transfers_.size(), nullptr);
    then_read_ = then_read;
    std::vector<Transfer*> run;
    for (Transfer& transfer : transfers_) {
      transfer.direction = direction;
      run.push_back(&transfer);
      if (!as_a_run_) backend_.start(transfer);
    }
    if (as_a_run_) backend_.start_run(run);
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kLongest, [&] {
      return std::ranges::all_of(ended_, [&](int times) { return times >= (then_read ? 2 : 1); });
    });
  }
  /// How often the transfer of the block ended.
  int ended(std::uint64_t block) {
    const std::scoped_lock lock(mutex_);
    return ended_[block];
  }
  /// Nothing for a transfer that succeeded.
  std::optional<ErrorCode> error(std::uint64_t block, CheckLog& log) {
    return error_of(log, [&] {
      if (errors_[block]) std::rethrow_exception(errors_[block]);
    });
  }

 private:
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    if (then_read_ && transfer.direction == Transfer::Direction::kWrite) {
      {
        const std::scoped_lock lock(mutex_);
        ++ended_[transfer.tag];
      }
      std::ranges::fill(transfer.memory, std::byte{0xa5});
      transfer.direction = Transfer::Direction::kRead;
      return backend_.start(transfer);
    }
    const std::scoped_lock lock(mutex_);
    ++ended_[transfer.tag];
    errors_[transfer.tag] = std::move(error);
    changed_.notify_all();
  }

  Backend& backend_;
  bool as_a_run_;
  std::vector<Bytes> memory_;
  std::deque<Transfer> transfers_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int> ended_;
  std::vector<std::exception_ptr> errors_;
  bool then_read_ = false;
};

/// Runs the transfers. If some do not end, the backend still has their memory, so it is never
/// freed.
void run(std::unique_ptr<AllBlocks>& blocks, CheckLog& log, Transfer::Direction direction,
         bool then_read = false) {
  const bool ended = blocks->run(direction, then_read);
  if (!ended) static_cast<void>(blocks.release());
  log.require(ended, "each transfer ends: its listener is called within a minute");
}

void check_damage(const Subject& subject, CheckLog& log, bool as_a_run) {
  LevelUnderTest level(subject);
  auto blocks = std::make_unique<AllBlocks>(level.open(), level.geometry(), as_a_run);
  run(blocks, log, Transfer::Direction::kWrite);
  level.table().entries()[2].checksum ^= 1;
  run(blocks, log, Transfer::Direction::kRead);
  for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block) {
    log.expect(blocks->ended(block) == 1, "each transfer ends once");
    const std::optional<ErrorCode> error = blocks->error(block, log);
    if (block == 2)
      log.expect(error == ErrorCode::kCorruption,
                 "read() compares the checksum in the table (kCorruption)");
    else
      log.expect(!error, "a damaged block lets no other block fail");
  }
  level.table().entries()[2].checksum ^= 1;
  run(blocks, log, Transfer::Direction::kRead);
  log.expect(!blocks->error(2, log), "a block whose checksum agrees again can be read");
}

void check_moves(const Subject& subject, CheckLog& log, bool as_a_run) {
  LevelUnderTest level(subject);
  auto blocks = std::make_unique<AllBlocks>(level.open(), level.geometry(), as_a_run);
  for (const bool then_read : {false, true}) {
    log.at(as_a_run    ? "start_run()"
           : then_read ? "each block is read from the listener of its write"
                       : "");
    std::vector<Bytes> contents;
    for (std::uint32_t block = 0; block < level.geometry().block_count(); ++block) {
      contents.push_back(make_content(level.geometry().block_bytes(block), Content::kSmooth,
                                      block + (then_read ? 100 : 1)));
      blocks->memory(block) = contents.back();
    }
    run(blocks, log, Transfer::Direction::kWrite, then_read);
    if (!then_read) {
      for (std::uint64_t block = 0; block < contents.size(); ++block)
        log.expect(blocks->memory(block) == contents[block],
                   "a write does not change the memory that it writes from");
      run(blocks, log, Transfer::Direction::kRead);
    }
    for (std::uint64_t block = 0; block < contents.size(); ++block) {
      log.expect(blocks->ended(block) == (then_read ? 2 : 1), "each transfer ends once");
      log.expect(!blocks->error(block, log), "no transfer fails");
      log.expect(blocks->memory(block) == contents[block], "a block reads as it was written");
    }
  }
}

}  // namespace

void check_transfers(const Subject& subject, CheckLog& log) {
  for (const bool as_a_run : {false, true}) check_moves(subject, log, as_a_run);
}

void check_damaged_transfer(const Subject& subject, CheckLog& log) {
  for (const bool as_a_run : {false, true}) check_damage(subject, log, as_a_run);
}

}  // namespace plait::conformance
