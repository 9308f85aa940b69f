#include <fmt/format.h>

#include <new>
#include <utility>

#include "paging/pager_implementation.h"
#include "plait/error.h"

namespace plait {

Frame* Pager::Implementation::claim(Lock& lock, LevelFile& level, std::uint64_t block) {
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  try {
    Frame* frame = nullptr;
    while (!(frame = take_frame(level, block)))
      if (!make_room(lock, level, frame_bytes)) return nullptr;
    ++frame->content.pins;
    return frame;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("page in {}: no memory for a frame of {} bytes", level.path.native(),
                            frame_bytes));
  }
}

Frame* Pager::Implementation::take_frame(LevelFile& level, std::uint64_t block) {
  if (vacant_.empty()) {
    Frame& added = frames_.emplace_back();
    added.index = static_cast<std::uint32_t>(frames_.size() - 1);
    vacant_.push_back(added);
  }
  // What a mapping holds for a block never written is not known to be zeros.
  const bool addressed = is_memory(level) || (level.traits.maps_for_reading && !level.writable &&
                                              was_written(level, block));
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  std::byte* memory = addressed ? level.backend->address(block) : nullptr;
  if (addressed && !pool_.reserve(frame_bytes)) return nullptr;
  if (!addressed) memory = pool_.take(frame_bytes);
  if (!memory) return nullptr;

  Frame& frame = vacant_.front();
  vacant_.pop_front();
  frame.content.level = &level;
  frame.content.block = block;
  frame.content.memory = memory;
  frame.content.block_bytes = level.geometry.block_bytes(block);
  frame.content.frame_bytes = frame_bytes;
  frame.content.sweep = sweep_;
  frame.content.state = State::kResident;
  frame.content.addressed = addressed;
  frame.transfer.backend = level.backend.get();
  frame.transfer.block = block;
  frame.transfer.memory = {memory, frame.content.block_bytes};
  frame.transfer.listener = this;
  frame.transfer.tag = frame.index;
  resident_[level.pager_slot][block] = frame.index;
  return &frame;
}

bool Pager::Implementation::make_room(Lock& lock, const LevelFile& wanted_by,
                                      std::uint64_t wanted_bytes) {
  if (Frame* const victim = clean_victim()) {
    evict(*victim);
    return true;
  }
  if (Frame* const dirty = eviction_->victim()) {
    write_here(lock, *dirty);
    return false;
  }
  if (writes_in_flight_ > 0) {
    wait(lock, Direction::kWrite);
    return false;
  }
  while (!ahead_.empty()) {
    Frame& last = *ahead_.rbegin();
    if (!last.content.dirty) {
      evict(last);
      return true;
    }
    if (!failed_) {
      write_here(lock, last);
      return false;
    }
    unsettle(last);  // its only copy: it stays
  }
  // Whoever reads a block may be done with it by then.
  if (reads_under_way_ > 0) {
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

/// nullptr: the next to be evicted is dirty, or there is none.
Frame* Pager::Implementation::clean_victim() noexcept {
  Frame* victim = eviction_->victim();
  while (victim && victim->content.dirty && failed_) {
    unsettle(*victim);  // its only copy: it stays
    victim = eviction_->victim();
  }
  return victim && !victim->content.dirty ? victim : nullptr;
}

void Pager::Implementation::evict(Frame& frame) noexcept {
  ++statistics_.blocks_evicted;
  const bool mapped = frame.content.addressed && !is_memory(*frame.content.level);
  drop(frame);
  if (!mapped) return;
  vacant_.erase(vacant_.iterator_to(frame));
  frame.content.state = State::kLeaving;
  leaving_.push_back(frame);
}

void Pager::Implementation::tell_evicted(Lock& lock) noexcept {
  while (!leaving_.empty()) {
    Frame& frame = leaving_.front();
    leaving_.pop_front();
    lock.unlock();
    frame.transfer.backend->advise({frame.transfer.block, 1}, Advice::kDontNeed);
    lock.lock();
    vacate(frame);
  }
}

void Pager::Implementation::drop(Frame& frame) noexcept {
  unsettle(frame);
  unannounce(frame);
  const Frame::Content& content = frame.content;
  if (content.addressed)
    pool_.unreserve(content.frame_bytes);
  else
    pool_.give_back(content.memory, content.frame_bytes);
  std::uint32_t& resident = resident_[content.level->pager_slot][content.block];
  if (resident == frame.index) resident = kNoId;
  vacate(frame);
}

void Pager::Implementation::vacate(Frame& frame) noexcept {
  frame.content = {};
  vacant_.push_back(frame);
}

void Pager::Implementation::settle(Frame& frame) noexcept {
  Frame::Content& content = frame.content;
  if (content.abandoned) return drop(frame);
  if (content.dirty && failed_) return;
  if (content.dirty && is_memory(*content.level)) {
    mark_written(frame);
    if (content.dirty) return;
  }
  if (content.dirty && writes_behind()) return stand(frame, Standing::kToWrite, 0);
  const EdgeId edge_after = content.level->geometry.edge_after(content.block);
  if (content.announced) return stand(frame, Standing::kAhead, edge_after);
  stand(frame, Standing::kEvictable, content.sweep == sweep_ ? edge_after : 0);
}

void Pager::Implementation::stand(Frame& frame, Standing standing, EdgeId order) noexcept {
  unsettle(frame);
  frame.content.standing = standing;
  frame.content.order = order;
  switch (standing) {
    case Standing::kNowhere:
      break;
    case Standing::kEvictable:
      eviction_->insert(frame);
      break;
    case Standing::kAhead:
      ahead_.insert(frame);
      break;
    case Standing::kToWrite:
      to_write_.push_back(frame);
      break;
  }
}

void Pager::Implementation::unsettle(Frame& frame) noexcept {
  switch (std::exchange(frame.content.standing, Standing::kNowhere)) {
    case Standing::kNowhere:
      break;
    case Standing::kEvictable:
      eviction_->erase(frame);
      break;
    case Standing::kAhead:
      ahead_.erase(ahead_.iterator_to(frame));
      break;
    case Standing::kToWrite:
      to_write_.erase(to_write_.iterator_to(frame));
      break;
  }
}

void Pager::Implementation::announce(Frame& frame) noexcept {
  if (!std::exchange(frame.content.announced, true)) announced_bytes_ += frame.content.frame_bytes;
}

void Pager::Implementation::unannounce(Frame& frame) noexcept {
  if (std::exchange(frame.content.announced, false)) announced_bytes_ -= frame.content.frame_bytes;
}

}  // namespace plait
