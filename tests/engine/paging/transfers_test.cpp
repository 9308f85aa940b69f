// What is on its way, without a pager: states, the bound, failures, context.
#include "paging/transfers.h"

#include <catch2/catch.hpp>
#include <deque>
#include <functional>
#include <vector>

#include "plait/error.h"
#include "support/error_of.h"

using namespace plait;
using plait::test::code_of;
using State = Frame::State;

namespace {

/// Keeps what is begun until the test ends it.
class KeepingBackend final : public Backend {
 public:
  void read(BlockRange, std::span<std::byte>) override {}
  void write(BlockRange, std::span<const std::byte>) override {}
  void start(Transfer& transfer) noexcept override { begun.push_back(&transfer); }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return 0; }
  std::vector<Transfer*> begun;
};

struct TransfersFixture final : TransferListener {
  TransfersFixture() : transfers(0, *this) {
    level.table = BlockTable({}, 3, 2, 4);
    for (std::uint32_t i = 0; i < 4; ++i) {
      Frame& frame = frames.emplace_back();
      frame.index = i;
      frame.content.level = &level;
      frame.content.block = i;
      frame.transfer.backend = &backend;
      frame.transfer.tag = i;
      become(frame, State::kClaimed);
    }
  }
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    transfers.ended(frames[transfer.tag], error);
  }
  void end(std::exception_ptr error = nullptr) {
    Transfer* const transfer = backend.begun.front();
    backend.begun.erase(backend.begun.begin());
    transfer->listener->finished(*transfer, error);
  }
  State state(std::size_t frame) const { return frames[frame].content.state; }

  std::mutex mutex;
  std::unique_lock<std::mutex> lock{mutex};
  LevelFile level;
  KeepingBackend backend;
  std::deque<Frame> frames;
  Transfers transfers;
};

std::exception_ptr full() {
  return std::make_exception_ptr(Error(ErrorCode::kNoSpace, "keeping: full"));
}

}  // namespace

TEST_CASE("TransfersRead_ThatEnds_MakesTheFrameCleanAndIsCounted") {
  TransfersFixture f;
  f.transfers.begin_read(f.frames[0]);
  f.transfers.begin_read(f.frames[1]);
  CHECK(f.state(0) == State::kReading);
  CHECK(f.transfers.reads() == 2);
  f.transfers.start(f.lock, f.frames[0]);
  f.transfers.start(f.lock, f.frames[1]);
  f.end();
  CHECK(f.state(0) == State::kClean);
  f.end(full());
  CHECK(f.state(1) == State::kReading);  // what becomes of it is not for Transfers to say
  CHECK(f.transfers.reads() == 0);
}

TEST_CASE("TransfersWrite_ThatEnds_LeavesDirtyWhatFailedOrWasHeldForWriting") {
  TransfersFixture f;
  for (std::size_t i = 0; i < 3; ++i) become(f.frames[i], State::kDirty);
  f.frames[1].content.writers = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    f.transfers.begin_write(f.frames[i]);
    f.transfers.start(f.lock, f.frames[i]);
  }
  CHECK(f.state(0) == State::kWriting);
  CHECK(f.state(1) == State::kWritingHeld);
  CHECK(f.transfers.writes() == 3);
  f.end();
  f.end();
  f.end(full());
  CHECK(f.state(0) == State::kClean);
  CHECK(f.state(1) == State::kDirty);
  CHECK(f.state(2) == State::kDirty);
  CHECK(f.transfers.writes() == 0);
}

TEST_CASE("TransfersFail_Refusals_GiveTheErrorOnceAndBeginNoQueuedWrite") {
  TransfersFixture f;
  become(f.frames[0], State::kDirty);
  f.transfers.queue_write(f.frames[0]);
  CHECK_FALSE(f.transfers.failed());
  f.transfers.fail(full());
  f.transfers.fail(nullptr);
  CHECK(f.transfers.failed());
  f.transfers.write_behind();
  CHECK(f.state(0) == State::kDirty);
  CHECK(code_of([&] { f.transfers.refuse("flush"); }) == ErrorCode::kNoSpace);
  CHECK(code_of([&] { f.transfers.refuse("flush"); }) == ErrorCode::kBadState);
}

TEST_CASE("TransfersWithdraw_WhatIsOnlyQueued_IsAsItWasBefore") {
  TransfersFixture f;
  become(f.frames[0], State::kDirty);
  f.transfers.begin_write(f.frames[0]);
  f.transfers.submit(f.frames[0]);
  f.transfers.begin_read(f.frames[1]);
  f.transfers.submit(f.frames[1]);
  CHECK(f.transfers.withdraw(f.frames[0]));
  CHECK(f.state(0) == State::kDirty);
  CHECK(f.transfers.help_any(f.lock, Transfer::Direction::kRead));
  CHECK_FALSE(f.transfers.help_any(f.lock, Transfer::Direction::kRead));
  CHECK_FALSE(f.transfers.withdraw(f.frames[1]));
  CHECK(f.transfers.writes() == 0);
  CHECK(f.backend.begun.size() == 1);
  f.end();
  CHECK(f.transfers.reads() == 0);
}

TEST_CASE("TransfersContext_HeldBlocks_TravelWithTheTransfer") {
  TransfersFixture f;
  std::vector<std::byte> bytes(8, std::byte{7});
  f.frames[0].transfer.memory = bytes;
  f.frames[1].context = std::make_unique<FrameContext>();
  f.frames[1].context->blocks[0] = &f.frames[0];
  f.frames[1].content.context_count = 1;
  f.transfers.begin_read(f.frames[1]);
  f.transfers.start(f.lock, f.frames[1]);
  const Transfer& transfer = *f.backend.begun.front();
  REQUIRE(transfer.context.size() == 1);
  CHECK(transfer.context[0].data() == bytes.data());
  f.end();
  f.frames[1].content.context_count = 0;
}
