#include "paging/transfers.h"

#include <fmt/format.h>

#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void Transfers::begin(Frame& frame, Direction direction) noexcept {
  frame.transfer.context = {};
  if (const std::size_t count = frame.content.context_count; count > 0) {
    for (std::size_t i = 0; i < count; ++i)
      frame.context->bytes[i] = frame.context->blocks[i]->transfer.memory;
    frame.transfer.context = std::span(frame.context->bytes).first(count);
  }
  frame.transfer.direction = direction;
  in_flight(direction) += weight(frame);
  frame.transfer.listener = &listener_;
}

std::uint64_t Transfers::weight(const Frame& frame) noexcept {
  return frame.transfer.run_log2 > 0 ? frame.content.frame_bytes : kRunBytes;
}

bool Transfers::may_begin(Direction direction) const noexcept {
  return in_flight_bytes_[direction == Direction::kRead ? 0 : 1] < Pager::kInFlight * kRunBytes;
}

void Transfers::begin_read(Frame& frame) noexcept {
  become(frame, Frame::State::kReading);
  frame.content.read_began = std::chrono::steady_clock::now();
  ++reads_;
  begin(frame, Direction::kRead);
}

void Transfers::begin_write(Frame& frame) noexcept {
  cancel_write(frame);
  become(frame, frame.content.writers > 0 ? Frame::State::kWritingHeld : Frame::State::kWriting);
  ++writes_;
  begin(frame, Direction::kWrite);
}

void Transfers::start(Lock& lock, const TransferRun& run) noexcept {
  lock.unlock();
  run.start();
  lock.lock();
}

void Transfers::help(Lock& lock, Frame& frame) noexcept {
  lock.unlock();
  queue_.begin(frame.transfer);
  lock.lock();
}

bool Transfers::help_any(Lock& lock, Direction direction) noexcept {
  lock.unlock();
  const bool began = queue_.begin_oldest(direction);
  lock.lock();
  return began;
}

bool Transfers::withdraw(Frame& frame) noexcept {
  if (!queue_.withdraw(frame.transfer)) return false;
  in_flight(frame.transfer.direction) -= weight(frame);
  if (is_being_written(frame.content.state)) {
    --writes_;
    become(frame, Frame::State::kDirty);
  } else {
    --reads_;
    become(frame, Frame::State::kClaimed);
  }
  return true;
}

void Transfers::ended(Frame& frame, const std::exception_ptr& error) noexcept {
  using State = Frame::State;
  in_flight(frame.transfer.direction) -= weight(frame);
  if (frame.content.state == State::kReading) {
    --reads_;
    if (!error) become(frame, State::kClean);
    return;
  }
  --writes_;
  const bool is_stored = !error && frame.content.state == State::kWriting;
  become(frame, is_stored ? State::kClean : State::kDirty);
}

void Transfers::queue_write(Frame& frame) noexcept {
  if (frame.transfer.run_log2 == 0) return to_write_.push_back(frame);
  const LevelFile& level = *frame.content.level;
  const BlockRange run = run_of(level, frame.content.block);
  waiting_.push_back(frame);
  waiting_bytes_ += frame.content.frame_bytes;
  frame.waits_for_run = true;
  // From the end: where blocks come in order, that is the one that is missing.
  bool whole = true;
  for (std::uint64_t at = run.count; whole && at-- > 0;) {
    const Frame* const other = level.frames[run.first + at].load(std::memory_order_relaxed);
    whole = other && other->to_write.is_linked();
  }
  if (whole) write_run_of(frame);
  while (waiting_bytes_ > most_waiting_bytes_ && write_waiting()) continue;
}

void Transfers::write_run_of(Frame& frame) noexcept {
  const LevelFile& level = *frame.content.level;
  const BlockRange run = run_of(level, frame.content.block);
  for (std::uint64_t block = run.first; block < run.first + run.count; ++block) {
    Frame* const other = level.frames[block].load(std::memory_order_relaxed);
    if (!other || !other->waits_for_run) continue;
    cancel_write(*other);
    to_write_.push_back(*other);
  }
}

bool Transfers::write_waiting() noexcept {
  if (waiting_.empty()) return false;
  write_run_of(waiting_.front());
  return true;
}

void Transfers::cancel_write(Frame& frame) noexcept {
  if (std::exchange(frame.waits_for_run, false)) waiting_bytes_ -= frame.content.frame_bytes;
  frame.to_write.unlink();
}

void Transfers::write_behind() noexcept {
  while (may_begin(Direction::kWrite) && !to_write_.empty()) {
    TransferRun run;
    do {
      Frame& frame = to_write_.front();
      if (!run.empty() && !follows(*run.transfers().back(), frame.transfer)) break;
      begin_write(frame);
      run.add(frame.transfer);
    } while (!to_write_.empty());
    submit(run);
  }
}

void Transfers::fail(std::exception_ptr error) noexcept {
  if (!std::exchange(failed_, true)) failure_ = std::move(error);
  to_write_.clear();
  while (!waiting_.empty()) cancel_write(waiting_.front());
}

void Transfers::refuse(std::string_view what) {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  throw Error(ErrorCode::kBadState,
              fmt::format("{}: refused because an earlier write failed; reopen the store", what));
}

PLAIT_END_NAMESPACE
