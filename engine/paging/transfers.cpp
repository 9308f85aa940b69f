#include "paging/transfers.h"

#include <fmt/format.h>

#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void Transfers::begin(Frame& frame, Direction direction) noexcept {
  const Frame::Content& content = frame.content;
  for (std::size_t i = 0; i < content.context_count; ++i)
    frame.context_bytes[i] = content.context[i]->transfer.memory;
  frame.transfer.context = {frame.context_bytes.data(), content.context_count};
  frame.transfer.direction = direction;
  frame.transfer.listener = &listener_;
}

void Transfers::begin_read(Frame& frame) noexcept {
  become(frame, Frame::State::kReading);
  frame.content.read_began = std::chrono::steady_clock::now();
  ++reads_;
  begin(frame, Direction::kRead);
}

void Transfers::begin_write(Frame& frame) noexcept {
  frame.to_write.unlink();
  become(frame, frame.content.writers > 0 ? Frame::State::kWritingHeld : Frame::State::kWriting);
  ++writes_;
  begin(frame, Direction::kWrite);
}

void Transfers::start(Lock& lock, Frame& frame) noexcept {
  lock.unlock();
  frame.transfer.backend->start(frame.transfer);
  lock.lock();
}

void Transfers::help(Lock& lock, Frame& frame) noexcept {
  if (queue_.withdraw(frame.transfer)) start(lock, frame);
}

bool Transfers::help_any(Lock& lock, Direction direction) noexcept {
  lock.unlock();
  const bool began = queue_.begin_oldest(direction);
  lock.lock();
  return began;
}

bool Transfers::withdraw(Frame& frame) noexcept {
  if (!queue_.withdraw(frame.transfer)) return false;
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
  if (frame.content.state == State::kReading) {
    --reads_;
    if (!error) become(frame, State::kClean);
    return;
  }
  --writes_;
  const bool is_stored = !error && frame.content.state == State::kWriting;
  become(frame, is_stored ? State::kClean : State::kDirty);
}

void Transfers::write_behind() noexcept {
  while (writes_ < Pager::kInFlight && !to_write_.empty()) {
    Frame& frame = to_write_.front();
    begin_write(frame);
    submit(frame);
  }
}

void Transfers::fail(std::exception_ptr error) noexcept {
  if (!std::exchange(failed_, true)) failure_ = std::move(error);
  to_write_.clear();
}

void Transfers::refuse(std::string_view what) {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  throw Error(ErrorCode::kBadState,
              fmt::format("{}: refused because an earlier write failed; reopen the store", what));
}

PLAIT_END_NAMESPACE
