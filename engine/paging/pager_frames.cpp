#include <fmt/format.h>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

std::uint32_t Pager::Implementation::claim(Lock& lock, LevelFile& level, std::uint64_t block) {
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  std::uint32_t entry = kNoId;
  while ((entry = take_frame(level, block)) == kNoId)
    if (!make_room(lock, level, frame_bytes)) return kNoId;
  ++frames_[entry].pins;
  return entry;
}

std::uint32_t Pager::Implementation::take_frame(LevelFile& level, std::uint64_t block) {
  // What a mapping holds for a block never written is not known to be zeros.
  const bool written = level.table[block].encoding != BlockEncoding::kNeverWritten;
  const bool direct =
      is_memory(level) || (level.traits.maps_for_reading && !level.writable && written);
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  std::byte* memory = direct ? level.backend->address(block) : nullptr;
  if (direct && !pool_.reserve(frame_bytes)) return kNoId;
  if (!direct) memory = pool_.take(frame_bytes);
  if (!memory) return kNoId;

  std::uint32_t entry = kNoId;
  if (vacant_entries_.empty()) {
    entry = static_cast<std::uint32_t>(frames_.size());
    frames_.emplace_back();
  } else {
    entry = vacant_entries_.back();
    vacant_entries_.pop_back();
  }
  Frame& frame = frames_[entry];
  frame = Frame();
  frame.level = &level;
  frame.block = block;
  frame.memory = memory;
  frame.block_bytes = level.geometry.block_bytes(block);
  frame.frame_bytes = frame_bytes;
  frame.direct = direct;
  frame.sweep = sweep_;
  frame.transfer.block = block;
  frame.transfer.memory = {memory, frame.block_bytes};
  frame.transfer.listener = this;
  frame.transfer.tag = entry;
  resident_[level.pager_slot][block] = entry;
  return entry;
}

bool Pager::Implementation::make_room(Lock& lock, const LevelFile& wanted_by,
                                      std::uint64_t wanted_bytes) {
  if (const std::uint32_t victim = clean_victim(); victim != kNoId) {
    evict(victim);
    return true;
  }
  if (const std::uint32_t dirty = eviction_->victim(); dirty != kNoId) {
    write_here(lock, dirty);
    return false;
  }
  if (writes_in_flight_ > 0) {
    wait(lock, Direction::kWrite);
    return false;
  }
  while (!announced_.empty()) {
    const std::uint32_t last = announced_.rbegin()->second;
    if (!frames_[last].dirty) {
      evict(last);
      return true;
    }
    if (!failed_) {
      write_here(lock, last);
      return false;
    }
    unsettle(last);  // its only copy: it stays
  }
  if (reads_ahead_ > 0) {
    wait(lock, Direction::kRead);
    return false;
  }
  if (failed_) refuse(fmt::format("page in {}", wanted_by.path.native()));
  throw Error(
      ErrorCode::kBudget,
      fmt::format("page in {}: a frame of {} bytes is needed, and all {} bytes in frames "
                  "are pinned under a budget of {} bytes",
                  wanted_by.path.native(), wanted_bytes, pool_.used_bytes(), pool_.budget_bytes()));
}

/// kNoId: the next to be evicted is dirty, or there is none.
std::uint32_t Pager::Implementation::clean_victim() {
  std::uint32_t victim = eviction_->victim();
  while (victim != kNoId && frames_[victim].dirty && failed_) {
    unsettle(victim);  // its only copy: it stays
    victim = eviction_->victim();
  }
  return victim != kNoId && !frames_[victim].dirty ? victim : kNoId;
}

void Pager::Implementation::evict(std::uint32_t entry) noexcept {
  const Frame& frame = frames_[entry];
  if (frame.direct && !is_memory(*frame.level))
    evicted_.emplace_back(frame.level->backend.get(), frame.block);
  drop(entry);
  ++statistics_.blocks_evicted;
}

void Pager::Implementation::say_goodbye(Lock& lock) noexcept {
  if (evicted_.empty()) return;
  const auto evicted = std::exchange(evicted_, {});
  lock.unlock();
  for (const auto& [backend, block] : evicted) backend->advise({block, 1}, Advice::kDontNeed);
}

void Pager::Implementation::drop(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  unsettle(entry);
  unannounce(entry);
  if (frame.waiting) std::erase(to_write_, entry);
  if (frame.direct)
    pool_.unreserve(frame.frame_bytes);
  else
    pool_.give_back(frame.memory, frame.frame_bytes);
  std::uint32_t& resident = resident_[frame.level->pager_slot][frame.block];
  if (resident == entry) resident = kNoId;
  frame = Frame();
  vacant_entries_.push_back(entry);
}

void Pager::Implementation::settle(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (frame.abandoned) return drop(entry);
  if (frame.dirty && failed_) return;
  if (frame.dirty && is_memory(*frame.level)) {
    mark_written(entry);
    if (frame.dirty) return;
  }
  if (frame.dirty && writes_behind()) {
    if (!std::exchange(frame.waiting, true)) to_write_.push_back(entry);
    return;
  }
  const EdgeId edge_after = frame.level->geometry.edge_after(frame.block);
  if (frame.announced) {
    announced_.emplace(edge_after, entry);
    return;
  }
  frame.evictable = true;
  frame.evictable_as = frame.sweep == sweep_ ? edge_after : 0;
  eviction_->insert(entry, frame.evictable_as);
}

void Pager::Implementation::unsettle(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (std::exchange(frame.evictable, false)) eviction_->erase(entry, frame.evictable_as);
  if (frame.announced) announced_.erase({frame.level->geometry.edge_after(frame.block), entry});
}

void Pager::Implementation::announce(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (!std::exchange(frame.announced, true)) announced_bytes_ += frame.frame_bytes;
}

void Pager::Implementation::unannounce(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (std::exchange(frame.announced, false)) announced_bytes_ -= frame.frame_bytes;
}

}  // namespace plait
