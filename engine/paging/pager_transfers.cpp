#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

void Pager::Implementation::bring_in(Lock& lock, SessionState& session, Frame& frame,
                                     Access access) {
  Frame::Content& content = frame.content;
  const LevelFile& level = *content.level;
  if (access == Access::kWrite) {
    content.dirty = true;
#ifndef NDEBUG
    if (!content.addressed) std::memset(content.memory, 0xcd, content.block_bytes);
#endif
    return;
  }
  const bool written = was_written(level, content.block);
  if (written && is_memory(level)) {
    count_transfer(frame, Direction::kRead);
  } else {
    content.state = State::kReading;
    ++reads_under_way_;
    if (!written) {
      lock.unlock();
      std::memset(content.memory, 0, content.block_bytes);
      lock.lock();
      content.state = State::kResident;
    } else {
      const Wait waiting(*this, &session, Direction::kRead);
      frame.transfer.direction = Direction::kRead;
      start(lock, frame);
      changed_.wait(lock, [&] { return content.state == State::kResident; });
    }
    // Not before: whoever waits for a frame would find this one neither being read nor free.
    --reads_under_way_;
    tell_of_change();
  }
  if (content.read_error) {
    const std::exception_ptr error = content.read_error;
    --content.pins;
    drop(frame);
    std::rethrow_exception(error);
  }
  if (access == Access::kUpdate) content.dirty = true;
}

/// Begins a frame's transfer in this thread; a backend without any of its own also ends it here.
void Pager::Implementation::start(Lock& lock, Frame& frame) noexcept {
  lock.unlock();
  frame.transfer.backend->start(frame.transfer);
  lock.lock();
}

void Pager::Implementation::tell_of_change() noexcept {
  ++changes_;
  changed_.notify_all();
}

void Pager::Implementation::finished(Transfer& transfer, std::exception_ptr error) noexcept {
  const Lock lock(mutex_);
  Frame& frame = frames_[transfer.tag];
  Frame::Content& content = frame.content;
  const bool was_reading = content.state == State::kReading;
  content.state = State::kResident;
  if (!was_reading) {
    --writes_in_flight_;
  } else if (content.pins == 0) {
    --reads_ahead_;
    --reads_under_way_;
  }
  if (!error) {
    count_transfer(frame, transfer.direction);
  } else if (was_reading) {
    // Whoever waits for the block finds it absent, and reads for itself.
    resident_[content.level->pager_slot][content.block] = kNoId;
    content.read_error = error;
  } else {
    content.dirty = true;
    fail(error);
  }
  if (content.pins == 0) {
    if (was_reading && error)
      drop(frame);
    else
      settle(frame);
  }
  write_behind();
  tell_of_change();
}

void Pager::Implementation::wait(Lock& lock, SessionState* session, Direction direction) noexcept {
  const Wait waiting(*this, session, direction);
  const std::uint64_t before = changes_;
  lock.unlock();
  const bool began = queue_.begin_oldest(direction);
  lock.lock();
  if (!began) wait_for_change(lock, before);
}

void Pager::Implementation::wait_for(Lock& lock, SessionState& session, Frame& frame) noexcept {
  const Wait waiting(*this, &session, frame.transfer.direction);
  const Frame::Content& content = frame.content;
  const LevelFile* const level = content.level;
  const std::uint64_t block = content.block;
  if (queue_.withdraw(frame.transfer)) start(lock, frame);
  changed_.wait(lock, [&] {
    return content.state == State::kResident || content.level != level || content.block != block;
  });
}

Frame* Pager::Implementation::take_clean_frame(SessionState& session, const LevelFile& level,
                                               std::uint64_t block) noexcept {
  try {
    while (true) {
      if (Frame* const frame = take_frame(session, level, block)) return frame;
      Frame* const clean =
          clean_victim(session, FramePool::frame_bytes(level.geometry.max_block_bytes()));
      if (!clean) return nullptr;
      evict(*clean);
    }
  } catch (...) {
    return nullptr;  // whoever pins the block will be told
  }
}

bool Pager::Implementation::prefetch(SessionState& session, const LevelFile& level,
                                     std::uint64_t block) noexcept {
  Lock lock(mutex_);
  if (Frame* const frame = frame_of(level, block)) {
    if (frame->content.pins > 0 || frame->content.announced) return true;
    const bool stood = frame->content.standing == Standing::kEvictable ||
                       frame->content.standing == Standing::kLeft;
    give(*frame, &session);
    announce(*frame);
    if (stood) settle(*frame);
    return true;
  }
  // The system is told of no block: it reads ahead by itself, and to be told costs a sweep as much
  // as the read (plait_bench_sweep_rmw).
  if (!was_written(level, block) || is_memory(level) || !queue_.has_threads()) return true;
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  if (reads_ahead_ >= kInFlight ||
      session.announced_bytes + frame_bytes + session.options.window_bytes > share_bytes(session))
    return false;
  Frame* const frame = take_clean_frame(session, level, block);
  if (frame) {
    announce(*frame);
    frame->content.state = State::kReading;
    ++reads_under_way_;
    ++reads_ahead_;
    ++statistics_.blocks_prefetched;
    ++session.statistics.blocks_prefetched;
    frame->transfer.direction = Direction::kRead;
    queue_.submit(frame->transfer);
  }
  tell_evicted(lock);
  return frame != nullptr;
}

void Pager::Implementation::begin_write(Frame& frame) noexcept {
  unsettle(frame);
  frame.content.state = State::kWriting;
  frame.content.dirty = frame.content.pins > 0;  // whoever holds it may still change it
  frame.transfer.direction = Direction::kWrite;
  ++writes_in_flight_;
}

void Pager::Implementation::mark_written(Frame& frame) noexcept {
  try {
    frame.transfer.backend->write({frame.content.block, 1}, frame.transfer.memory);
    frame.content.dirty = frame.content.pins > 0;
    count_transfer(frame, Direction::kWrite);
  } catch (...) {
    fail(std::current_exception());
  }
}

void Pager::Implementation::write_here(Lock& lock, SessionState* session, Frame& frame) {
  const Wait waiting(*this, session, Direction::kWrite);
  const std::uint64_t before = changes_;
  begin_write(frame);
  start(lock, frame);
  if (changes_ == before) wait_for_change(lock, before);
  if (failed_) refuse("write back");
}

void Pager::Implementation::write_behind() noexcept {
  while (writes_in_flight_ < kInFlight && !to_write_.empty()) {
    Frame& frame = to_write_.front();
    begin_write(frame);
    queue_.submit(frame.transfer);
  }
}

void Pager::Implementation::flush() {
  Lock lock(mutex_);
  if (failed_) refuse("flush");
  std::vector<Frame*> dirty;
  for (Frame& frame : frames_)
    if (frame.content.dirty) dirty.push_back(&frame);
  std::ranges::sort(dirty, {}, [](const Frame* frame) {
    return std::pair(frame->content.level->pager_slot, frame->content.block);
  });
  for (Frame* const frame : dirty) {
    while (!failed_ && writes_in_flight_ >= kInFlight) wait(lock, nullptr, Direction::kWrite);
    if (failed_) break;
    const Frame::Content& content = frame->content;
    if (!content.dirty || content.state != State::kResident) continue;
    if (is_memory(*content.level)) {
      mark_written(*frame);
    } else if (queue_.has_threads()) {
      begin_write(*frame);
      queue_.submit(frame->transfer);
    } else {
      write_here(lock, nullptr, *frame);
    }
  }
  while (writes_in_flight_ > 0) wait(lock, nullptr, Direction::kWrite);
  if (failed_) refuse("flush");
}

void Pager::Implementation::stop_transfers(Lock& lock, const LevelFile* level) noexcept {
  const auto on_its_way = [&](const Frame& frame) {
    return (frame.content.state == State::kReading || frame.content.state == State::kWriting) &&
           (!level || frame.content.level == level);
  };
  for (Frame& frame : frames_) {
    if (frame.content.standing == Standing::kToWrite && (!level || frame.content.level == level))
      unsettle(frame);
    if (!on_its_way(frame) || !queue_.withdraw(frame.transfer)) continue;
    if (frame.content.state == State::kWriting) {
      --writes_in_flight_;
      frame.content.dirty = true;
    } else {
      --reads_ahead_;
      --reads_under_way_;
    }
    frame.content.state = State::kResident;
  }
  changed_.wait(lock, [&] { return std::ranges::none_of(frames_, on_its_way); });
}

void Pager::Implementation::fail(std::exception_ptr error) noexcept {
  if (!std::exchange(failed_, true)) failure_ = std::move(error);
  while (!to_write_.empty()) unsettle(to_write_.front());
}

void Pager::Implementation::refuse(std::string_view what) {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  throw Error(ErrorCode::kBadState,
              fmt::format("{}: refused since an earlier write failed; reopen the store", what));
}

void Pager::Implementation::count_transfer(const Frame& frame, Direction direction) noexcept {
  const bool read = direction == Direction::kRead;
  const auto count = [&](PagingStatistics& statistics) {
    ++(read ? statistics.blocks_read : statistics.blocks_written);
    (read ? statistics.bytes_read : statistics.bytes_written) += frame.content.block_bytes;
  };
  count(statistics_);
  if (frame.content.session) count(frame.content.session->statistics);
}

}  // namespace plait
