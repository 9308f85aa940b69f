#include "plait/pager.h"

#include <fmt/format.h>

#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Pager::Implementation::Implementation(std::uint64_t budget_bytes, int io_threads)
    : pool_(budget_bytes), queue_(io_threads) {}

Pager::Implementation::~Implementation() {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (Frame& frame : frames_)
    if (frame.content.level) drop(frame);
}

void Pager::Implementation::attach(LevelFile& level) {
  const Lock lock(mutex_);
  if (!is_memory(level)) queue_.start_threads();
  if (vacant_slots_.empty()) {
    vacant_slots_.reserve(resident_.size() + 1);
    level.pager_slot = static_cast<std::uint32_t>(resident_.size());
    resident_.emplace_back();
  } else {
    level.pager_slot = vacant_slots_.back();
    vacant_slots_.pop_back();
  }
  resident_[level.pager_slot].assign(level.geometry.block_count(), kNoId);
}

void Pager::Implementation::detach(LevelFile& level) {
  Lock lock(mutex_);
  if (level.pager_slot == kNoId) return;
  stop_transfers(lock, &level);
  tell_evicted(lock);
  for (const std::uint32_t index : resident_[level.pager_slot])
    if (index != kNoId) drop(frames_[index]);
  resident_[level.pager_slot].clear();
  vacant_slots_.push_back(std::exchange(level.pager_slot, kNoId));
}

Frame& Pager::Implementation::pin(LevelFile& level, std::uint64_t block, Access access) {
  if (access != Access::kRead && !level.writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: the level was opened for reading", level.path.native()));
  Lock lock(mutex_);
  while (true) {
    if (access != Access::kRead && failed_) refuse(fmt::format("write {}", level.path.native()));
    Frame* frame = frame_of(level, block);
    if (!frame) {
      frame = claim(lock, level, block);
      if (!frame) continue;
      bring_in(lock, *frame, access);
    } else {
      Frame::Content& content = frame->content;
      if (content.state == State::kReading ||
          (content.state == State::kWriting && access != Access::kRead)) {
        wait_for(lock, *frame);
        continue;
      }
      unsettle(*frame);
      unannounce(*frame);
      ++content.pins;
      content.sweep = sweep_;
      if (access != Access::kRead) content.dirty = true;
    }
    tell_evicted(lock);
    return *frame;
  }
}

void Pager::Implementation::unpin(std::uint32_t index, bool abandoned) noexcept {
  const Lock lock(mutex_);
  Frame& frame = frames_[index];
  if (abandoned) frame.content.abandoned = frame.content.level->left_unfinished = true;
  if (--frame.content.pins > 0 || frame.content.state != State::kResident) return;
  settle(frame);
  write_behind();
}

void Pager::Implementation::refuse_writes() noexcept {
  const Lock lock(mutex_);
  fail(nullptr);
}

void Pager::Implementation::discard() noexcept {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (Frame& frame : frames_)
    if (frame.content.level && frame.content.pins == 0) drop(frame);
}

void Pager::Implementation::set_policy(EvictionPolicy policy, std::uint64_t window_bytes) noexcept {
  const Lock lock(mutex_);
  window_bytes_ = window_bytes;
  for (Frame& frame : frames_)
    if (frame.content.level) {
      unsettle(frame);
      unannounce(frame);
    }
  policy_ = policy;
  eviction_ = policy == EvictionPolicy::kClock ? static_cast<Eviction*>(&clock_) : &window_;
  ++sweep_;
  for (Frame& frame : frames_)
    if (frame.content.level && frame.content.pins == 0 && frame.content.state == State::kResident)
      settle(frame);
  write_behind();
}

void Pager::Implementation::set_aside(std::uint64_t bytes) noexcept {
  const Lock lock(mutex_);
  pool_.set_aside(bytes);
}

std::uint64_t Pager::Implementation::budget_bytes() const noexcept {
  const Lock lock(mutex_);
  return pool_.budget_bytes();
}

PagingStatistics Pager::Implementation::statistics() const {
  const Lock lock(mutex_);
  PagingStatistics statistics = statistics_;
  statistics.peak_frame_bytes = pool_.peak_bytes();
  return statistics;
}

PinnedBlock::PinnedBlock(PinnedBlock&& other) noexcept
    : pager_(std::exchange(other.pager_, nullptr)),
      frame_(other.frame_),
      writes_(other.writes_),
      bytes_(other.bytes_) {}

PinnedBlock& PinnedBlock::operator=(PinnedBlock&& other) noexcept {
  if (this != &other) {
    release();
    pager_ = std::exchange(other.pager_, nullptr);
    frame_ = other.frame_;
    writes_ = other.writes_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void PinnedBlock::release() noexcept {
  if (pager_) std::exchange(pager_, nullptr)->implementation_->unpin(frame_, false);
}

void PinnedBlock::abandon() noexcept {
  if (pager_) std::exchange(pager_, nullptr)->implementation_->unpin(frame_, writes_);
}

Pager::Pager(std::uint64_t budget_bytes, int io_threads)
    : implementation_(std::make_unique<Implementation>(budget_bytes, io_threads)) {}
Pager::~Pager() = default;
void Pager::attach(LevelFile& level) { implementation_->attach(level); }
void Pager::detach(LevelFile& level) { implementation_->detach(level); }

PinnedBlock Pager::pin(LevelFile& level, std::uint64_t block, Access access) {
  PinnedBlock pinned;
  const Frame& frame = implementation_->pin(level, block, access);
  pinned.frame_ = frame.index;
  pinned.bytes_ = frame.transfer.memory;
  pinned.writes_ = access != Access::kRead;
  pinned.pager_ = this;
  return pinned;
}

bool Pager::prefetch(LevelFile& level, std::uint64_t block) noexcept {
  return implementation_->prefetch(level, block);
}

void Pager::flush() { implementation_->flush(); }
void Pager::refuse_writes() noexcept { implementation_->refuse_writes(); }
void Pager::discard() noexcept { implementation_->discard(); }

void Pager::set_aside(std::uint64_t bytes) noexcept { implementation_->set_aside(bytes); }

void Pager::set_policy(EvictionPolicy policy, std::uint64_t window_bytes) noexcept {
  implementation_->set_policy(policy, window_bytes);
}

std::uint64_t Pager::budget_bytes() const noexcept { return implementation_->budget_bytes(); }
PagingStatistics Pager::statistics() const { return implementation_->statistics(); }

}  // namespace plait
