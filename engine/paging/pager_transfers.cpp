#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

void Pager::Implementation::bring_in(Lock& lock, std::uint32_t entry, Access access) {
  Frame& frame = frames_[entry];
  if (access == Access::kWrite) {
    frame.dirty = true;
#ifndef NDEBUG
    if (!frame.direct) std::memset(frame.memory, 0xcd, frame.block_bytes);
#endif
    return;
  }
  frame.activity = Activity::kReading;
  const bool written = frame.level->table[frame.block].encoding != BlockEncoding::kNeverWritten;
  if (!written || is_memory(*frame.level)) {
    lock.unlock();
    if (!written) std::memset(frame.memory, 0, frame.block_bytes);
    lock.lock();
    frame.activity = Activity::kNone;
    if (written) count_transfer(frame, Direction::kRead);
    ++changes_;
    changed_.notify_all();
  } else {
    const Wait waiting(statistics_, Direction::kRead);
    frame.transfer.direction = Direction::kRead;
    start(lock, entry);
    changed_.wait(lock, [&] { return frame.activity == Activity::kNone; });
  }
  if (frame.read_error) {
    const std::exception_ptr error = frame.read_error;
    --frame.pins;
    drop(entry);
    std::rethrow_exception(error);
  }
  if (access == Access::kUpdate) frame.dirty = true;
}

/// Begins a frame's transfer in this thread; a backend without any of its own also ends it here.
void Pager::Implementation::start(Lock& lock, std::uint32_t entry) {
  Frame& frame = frames_[entry];
  Backend& backend = *frame.level->backend;
  lock.unlock();
  backend.start(frame.transfer);
  lock.lock();
}

void Pager::Implementation::finished(Transfer& transfer, std::exception_ptr error) noexcept {
  const Lock lock(mutex_);
  const std::uint32_t entry = transfer.tag;
  Frame& frame = frames_[entry];
  const bool was_reading = frame.activity == Activity::kReading;
  frame.activity = Activity::kNone;
  if (was_reading && frame.pins == 0) --reads_ahead_;
  if (!was_reading) --writes_in_flight_;
  if (!error) {
    count_transfer(frame, transfer.direction);
  } else if (was_reading) {
    // Whoever waits for the block finds it absent, and reads for itself.
    resident_[frame.level->pager_slot][frame.block] = kNoId;
    frame.read_error = error;
  } else {
    frame.dirty = true;
    fail(error);
  }
  if (frame.pins == 0) {
    if (was_reading && error)
      drop(entry);
    else
      settle(entry);
  }
  write_behind();
  ++changes_;
  changed_.notify_all();
}

void Pager::Implementation::wait(Lock& lock, Direction direction) {
  const Wait waiting(statistics_, direction);
  const std::uint64_t before = changes_;
  lock.unlock();
  const bool began = queue_.begin_oldest(direction);
  lock.lock();
  if (!began) wait_for_change(lock, before);
}

void Pager::Implementation::wait_for(Lock& lock, std::uint32_t entry) {
  const Frame& frame = frames_[entry];
  const Wait waiting(statistics_, frame.transfer.direction);
  const LevelFile* const level = frame.level;
  const std::uint64_t block = frame.block;
  if (queue_.withdraw(frame.transfer)) start(lock, entry);
  changed_.wait(lock, [&] {
    return frame.activity == Activity::kNone || frame.level != level || frame.block != block;
  });
}

std::uint32_t Pager::Implementation::take_clean_frame(LevelFile& level,
                                                      std::uint64_t block) noexcept {
  try {
    while (true) {
      if (const std::uint32_t entry = take_frame(level, block); entry != kNoId) return entry;
      const std::uint32_t victim = clean_victim();
      if (victim == kNoId) return kNoId;
      evict(victim);
    }
  } catch (...) {
    return kNoId;  // whoever pins the block will be told
  }
}

bool Pager::Implementation::prefetch(LevelFile& level, std::uint64_t block) noexcept {
  Lock lock(mutex_);
  if (const std::uint32_t entry = resident_[level.pager_slot][block]; entry != kNoId) {
    const Frame& frame = frames_[entry];
    if (frame.pins > 0 || frame.announced) return true;
    const bool settled = frame.evictable;
    if (settled) unsettle(entry);
    announce(entry);
    frames_[entry].sweep = sweep_;
    if (settled) settle(entry);
    return true;
  }
  // The system is told of no block: it reads ahead by itself, and to be told costs a sweep as much
  // as the read (plait_bench_sweep_rmw).
  if (level.table[block].encoding == BlockEncoding::kNeverWritten || is_memory(level) ||
      !queue_.has_threads())
    return true;
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  if (reads_ahead_ >= kInFlight ||
      announced_bytes_ + frame_bytes + window_bytes_ > pool_.budget_bytes())
    return false;
  const std::uint32_t entry = take_clean_frame(level, block);
  if (entry != kNoId) {
    announce(entry);
    frames_[entry].activity = Activity::kReading;
    frames_[entry].transfer.direction = Direction::kRead;
    ++reads_ahead_;
    ++statistics_.blocks_prefetched;
    queue_.submit(*level.backend, frames_[entry].transfer);
  }
  say_goodbye(lock);
  return entry != kNoId;
}

void Pager::Implementation::begin_write(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  unsettle(entry);
  frame.activity = Activity::kWriting;
  frame.transfer.direction = Direction::kWrite;
  frame.dirty = frame.pins > 0;  // whoever holds it may still change it
  ++writes_in_flight_;
}

void Pager::Implementation::mark_written(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  try {
    frame.level->backend->write({frame.block, 1}, frame.transfer.memory);
    frame.dirty = frame.pins > 0;
    count_transfer(frame, Direction::kWrite);
  } catch (...) {
    fail(std::current_exception());
  }
}

void Pager::Implementation::write_here(Lock& lock, std::uint32_t entry) {
  const Wait waiting(statistics_, Direction::kWrite);
  const std::uint64_t before = changes_;
  begin_write(entry);
  start(lock, entry);
  if (changes_ == before) wait_for_change(lock, before);
  if (failed_) refuse("write back");
}

void Pager::Implementation::write_behind() noexcept {
  while (writes_in_flight_ < kInFlight && !to_write_.empty()) {
    const std::uint32_t entry = to_write_.front();
    to_write_.pop_front();
    Frame& frame = frames_[entry];
    frame.waiting = false;
    if (frame.pins > 0 || !frame.dirty || frame.activity != Activity::kNone) continue;
    begin_write(entry);
    queue_.submit(*frame.level->backend, frame.transfer);
  }
}

void Pager::Implementation::flush() {
  Lock lock(mutex_);
  if (failed_) refuse("flush");
  std::vector<std::uint32_t> dirty;
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry)
    if (frames_[entry].level && frames_[entry].dirty) dirty.push_back(entry);
  std::ranges::sort(dirty, {}, [&](std::uint32_t entry) {
    return std::pair(frames_[entry].level->pager_slot, frames_[entry].block);
  });
  for (const std::uint32_t entry : dirty) {
    while (!failed_ && writes_in_flight_ >= kInFlight) wait(lock, Direction::kWrite);
    Frame& frame = frames_[entry];
    if (failed_) break;
    if (!frame.level || !frame.dirty || frame.activity != Activity::kNone) continue;
    if (is_memory(*frame.level)) {
      mark_written(entry);
    } else if (queue_.has_threads()) {
      begin_write(entry);
      queue_.submit(*frame.level->backend, frame.transfer);
    } else {
      write_here(lock, entry);
    }
  }
  while (writes_in_flight_ > 0) wait(lock, Direction::kWrite);
  if (failed_) refuse("flush");
}

void Pager::Implementation::stop_transfers(Lock& lock, const LevelFile* level) noexcept {
  const auto concerns = [&](const Frame& frame) {
    return frame.level && (!level || frame.level == level);
  };
  std::erase_if(to_write_, [&](std::uint32_t entry) {
    if (!concerns(frames_[entry])) return false;
    frames_[entry].waiting = false;
    return true;
  });
  for (Frame& frame : frames_) {
    if (!concerns(frame) || frame.activity == Activity::kNone || !queue_.withdraw(frame.transfer))
      continue;
    if (frame.activity == Activity::kWriting) {
      --writes_in_flight_;
      frame.dirty = true;
    } else {
      --reads_ahead_;
    }
    frame.activity = Activity::kNone;
  }
  changed_.wait(lock, [&] {
    return std::ranges::none_of(frames_, [&](const Frame& frame) {
      return concerns(frame) && frame.activity != Activity::kNone;
    });
  });
}

void Pager::Implementation::fail(std::exception_ptr error) noexcept {
  if (!std::exchange(failed_, true)) failure_ = std::move(error);
  for (const std::uint32_t entry : to_write_) frames_[entry].waiting = false;
  to_write_.clear();
}

void Pager::Implementation::refuse(std::string_view what) {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  throw Error(ErrorCode::kBadState,
              fmt::format("{}: refused since an earlier write failed; reopen the store", what));
}

void Pager::Implementation::count_transfer(const Frame& frame, Direction direction) noexcept {
  const bool read = direction == Direction::kRead;
  ++(read ? statistics_.blocks_read : statistics_.blocks_written);
  (read ? statistics_.bytes_read : statistics_.bytes_written) += frame.block_bytes;
}

}  // namespace plait
