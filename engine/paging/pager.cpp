#include "plait/pager.h"

#include <fmt/format.h>

#include <tuple>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Pager::Implementation::Implementation(std::uint64_t budget_bytes, int io_threads)
    : pool_(budget_bytes), eviction_(make_eviction(policy_)), queue_(io_threads) {}

Pager::Implementation::~Implementation() {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry)
    if (frames_[entry].level) drop(entry);
}

void Pager::Implementation::attach(LevelFile& level) {
  const Lock lock(mutex_);
  if (!is_memory(level)) queue_.start_threads();
  if (vacant_slots_.empty()) {
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
  std::erase_if(evicted_, [&](const auto& of) { return of.first == level.backend.get(); });
  for (const std::uint32_t entry : resident_[level.pager_slot])
    if (entry != kNoId) drop(entry);
  resident_[level.pager_slot].clear();
  vacant_slots_.push_back(std::exchange(level.pager_slot, kNoId));
}

std::pair<std::uint32_t, std::span<std::byte>> Pager::Implementation::pin(LevelFile& level,
                                                                          std::uint64_t block,
                                                                          Access access) {
  if (access != Access::kRead && !level.writable)
    throw Error(ErrorCode::kBadState, fmt::format("write {}: the level was opened for reading",
                                                  level.path.native()));
  Lock lock(mutex_);
  while (true) {
    if (access != Access::kRead && failed_) refuse(fmt::format("write {}", level.path.native()));
    std::uint32_t entry = resident_[level.pager_slot][block];
    if (entry == kNoId) {
      entry = claim(lock, level, block);
      if (entry == kNoId) continue;
      bring_in(lock, entry, access);
    } else {
      Frame& frame = frames_[entry];
      if (frame.activity == Activity::kReading ||
          (frame.activity == Activity::kWriting && access != Access::kRead)) {
        wait_for(lock, entry);
        continue;
      }
      unsettle(entry);
      unannounce(entry);
      ++frame.pins;
      frame.sweep = sweep_;
      if (access != Access::kRead) frame.dirty = true;
    }
    const std::span<std::byte> bytes = frames_[entry].transfer.memory;
    say_goodbye(lock);
    return {entry, bytes};
  }
}

void Pager::Implementation::unpin(std::uint32_t entry, bool abandoned) noexcept {
  const Lock lock(mutex_);
  Frame& frame = frames_[entry];
  if (abandoned) frame.abandoned = frame.level->unfinished = true;
  if (--frame.pins > 0 || frame.activity != Activity::kNone) return;
  settle(entry);
  write_behind();
}

void Pager::Implementation::refuse_writes() noexcept {
  const Lock lock(mutex_);
  fail(nullptr);
}

void Pager::Implementation::discard() noexcept {
  Lock lock(mutex_);
  stop_transfers(lock, nullptr);
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry)
    if (frames_[entry].level && frames_[entry].pins == 0) drop(entry);
}

void Pager::Implementation::set_policy(EvictionPolicy policy, std::uint64_t window_bytes) {
  const Lock lock(mutex_);
  policy_ = policy;
  window_bytes_ = window_bytes;
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry)
    if (frames_[entry].level) {
      unsettle(entry);
      unannounce(entry);
    }
  eviction_ = make_eviction(policy);
  ++sweep_;
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry) {
    const Frame& frame = frames_[entry];
    if (frame.level && frame.pins == 0 && frame.activity == Activity::kNone) settle(entry);
  }
  write_behind();
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
  std::tie(pinned.frame_, pinned.bytes_) = implementation_->pin(level, block, access);
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

void Pager::set_policy(EvictionPolicy policy, std::uint64_t window_bytes) {
  implementation_->set_policy(policy, window_bytes);
}

std::uint64_t Pager::budget_bytes() const noexcept { return implementation_->budget_bytes(); }
PagingStatistics Pager::statistics() const { return implementation_->statistics(); }

}  // namespace plait
