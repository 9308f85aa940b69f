// The part of the suite about Backend::start, the way by which the pager moves blocks: all blocks
// of a level on their way at once.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <vector>

#include "backends/conformance.h"
#include "plait/error.h"

namespace plait::test {
namespace {

/// Transfers of all blocks of a level, each with memory of its own, and how they ended.
class AllBlocks final : public TransferListener {
 public:
  AllBlocks(Backend& backend, const LevelGeometry& geometry)
      : backend_(backend), memory_(geometry.block_count()), transfers_(geometry.block_count()) {
    for (std::uint32_t block = 0; block < transfers_.size(); ++block) {
      memory_[block].assign(geometry.block_bytes(block), std::byte{0xa5});
      transfers_[block].block = block;
      transfers_[block].memory = memory_[block];
      transfers_[block].listener = this;
      transfers_[block].tag = block;
    }
  }

  std::vector<std::byte>& memory(std::uint64_t block) { return memory_[block]; }
  /// Every block that was written is read at once when its write has ended, from its listener.
  void run(Transfer::Direction direction, bool then_read = false) {
    ended_.assign(transfers_.size(), 0);
    errors_.assign(transfers_.size(), nullptr);
    then_read_ = then_read;
    for (Transfer& transfer : transfers_) {
      transfer.direction = direction;
      backend_.start(transfer);
    }
    std::unique_lock lock(mutex_);
    const int expected = then_read ? 2 : 1;
    changed_.wait(lock, [&] {
      for (const int times : ended_)
        if (times < expected) return false;
      return true;
    });
  }
  /// How often the transfer of the block ended.
  int ended(std::uint64_t block) const { return ended_[block]; }
  ErrorCode error(std::uint64_t block) const {
    try {
      if (errors_[block]) std::rethrow_exception(errors_[block]);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kCancelled;  // which no backend throws
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
    errors_[transfer.tag] = error;
    changed_.notify_all();
  }

  Backend& backend_;
  std::vector<std::vector<std::byte>> memory_;
  std::deque<Transfer> transfers_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int> ended_;
  std::vector<std::exception_ptr> errors_;
  bool then_read_ = false;
};

}  // namespace

TEST_CASE("BackendStart_AllBlocksOnTheirWay_EndsEachOnceWithItsBytes") {
  for (const auto& subject : backends_under_test()) {
    if (subject.entry.traits.in_memory) continue;  // the pager begins no transfer there
    INFO(subject.label);
    LevelUnderTest level(subject);
    AllBlocks blocks(level.open(), level.geometry());
    for (const bool then_read : {false, true}) {
      std::vector<std::vector<std::byte>> contents;
      for (std::uint32_t block = 0; block < level.geometry().block_count(); ++block) {
        contents.push_back(make_content(level.geometry().block_bytes(block), Content::kSmooth,
                                        block + (then_read ? 100 : 1)));
        blocks.memory(block) = contents.back();
      }
      blocks.run(Transfer::Direction::kWrite, then_read);
      if (!then_read) {
        for (std::uint64_t block = 0; block < contents.size(); ++block)
          CHECK(blocks.memory(block) == contents[block]);  // a write changes nothing
        blocks.run(Transfer::Direction::kRead);
      }
      for (std::uint64_t block = 0; block < contents.size(); ++block) {
        CHECK(blocks.ended(block) == (then_read ? 2 : 1));
        CHECK(blocks.error(block) == ErrorCode::kCancelled);
        CHECK(blocks.memory(block) == contents[block]);
      }
    }
  }
}

TEST_CASE("BackendStart_OneBlockIsDamaged_FailsThatTransferAndNoOther") {
  for (const auto& subject : backends_under_test()) {
    if (subject.entry.traits.in_memory) continue;
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    AllBlocks blocks(backend, level.geometry());
    blocks.run(Transfer::Direction::kWrite);
    level.table().entries()[2].checksum ^= 1;
    blocks.run(Transfer::Direction::kRead);
    for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block) {
      CHECK(blocks.ended(block) == 1);
      CHECK(blocks.error(block) == (block == 2 ? ErrorCode::kCorruption : ErrorCode::kCancelled));
    }
    level.table().entries()[2].checksum ^= 1;
    blocks.run(Transfer::Direction::kRead);
    CHECK(blocks.error(2) == ErrorCode::kCancelled);
  }
}

TEST_CASE("BackendContext_BuiltInBackends_NeedNone") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    std::array<ContextBlock, kMostContextBlocks> blocks;
    CHECK(level.open().context(0, blocks) == 0);
  }
}

}  // namespace plait::test
