#include "paging/frame_table.h"

#include <algorithm>
#include <cassert>

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The most blocks that can be in frames at once after `added` is attached.
std::uint64_t FrameTable::most_frames(const LevelFile& added) const noexcept {
  std::uint64_t all = 0, smallest = frame_bytes(added);
  const auto count = [&](const LevelFile& level) {
    smallest = std::min(smallest, frame_bytes(level));
    all += std::min(level.geometry.block_count(), pool_.most_bytes() / frame_bytes(level));
  };
  count(added);
  for (const LevelFrames& slot : slots_)
    if (slot.level) count(*slot.level);
  // Twice, because a detached frame may still have the memory of a block that is in another frame.
  return std::min(2 * all, pool_.most_bytes() / smallest);
}

void FrameTable::attach(LevelFile& level) {
  pool_.prepare(frame_bytes(level));
  const std::uint64_t most = most_frames(level);
  while (frames_.size() < most) {
    Frame& frame = frames_.emplace_back();
    frame.index = static_cast<std::uint32_t>(frames_.size() - 1);
    vacant_.push_back(frame);
  }
  auto slot = std::ranges::find(slots_, nullptr, &LevelFrames::level);
  if (slot == slots_.end()) {
    slots_.emplace_back();
    slot = slots_.end() - 1;
  }
  slot->frames.assign(level.geometry.block_count(), kNoId);
  slot->level = &level;
  level.pager_slot = static_cast<std::uint32_t>(slot - slots_.begin());
}

void FrameTable::detach(LevelFile& level) noexcept {
  LevelFrames& slot = slots_[level.pager_slot];
  assert(std::ranges::all_of(slot.frames, [](std::uint32_t index) { return index == kNoId; }));
  slot.level = nullptr;
  slot.frames = {};
  level.pager_slot = kNoId;
}

const LevelFile* FrameTable::level(std::uint32_t attribute, int number) const noexcept {
  for (const LevelFrames& slot : slots_)
    if (slot.level && slot.level->table.attribute() == attribute &&
        slot.level->table.level() == number)
      return slot.level;
  return nullptr;
}

Frame* FrameTable::find(const LevelFile& level, std::uint64_t block) noexcept {
  const std::uint32_t index = slots_[level.pager_slot].frames[block];
  return index == kNoId ? nullptr : &frames_[index];
}

Frame* FrameTable::claim(const LevelFile& level, std::uint64_t block, std::byte* address) {
  assert(!find(level, block));
  const std::uint64_t bytes = frame_bytes(level);
  std::byte* const memory = !address ? pool_.take(bytes) : pool_.reserve(bytes) ? address : nullptr;
  if (!memory) return nullptr;
  // This is rare: many blocks were detached more than once.
  if (vacant_.empty()) {
    if (address)
      pool_.unreserve(bytes);
    else
      pool_.give_back(memory, bytes);
    return nullptr;
  }
  Frame& frame = vacant_.front();
  frame.in_list.unlink();
  become(frame, Frame::State::kClaimed);
  Frame::Content& content = frame.content;
  content.level = &level;
  content.block = block;
  content.memory = memory;
  content.block_bytes = level.geometry.block_bytes(block);
  content.frame_bytes = bytes;
  content.addressed = address != nullptr;
  content.order = level.geometry.edge_after(block);
  frame.transfer.backend = level.backend.get();
  frame.transfer.block = block;
  frame.transfer.memory = {memory, content.block_bytes};
  frame.transfer.tag = frame.index;
  slots_[level.pager_slot].frames[block] = frame.index;
  return &frame;
}

void FrameTable::detach_block(Frame& frame) noexcept {
  become(frame, Frame::State::kDetached);
  slots_[frame.content.level->pager_slot].frames[frame.content.block] = kNoId;
}

void FrameTable::vacate(Frame& frame) noexcept {
  const Frame::Content& content = frame.content;
  assert(content.pins == 0 && content.context_count == 0);
  assert(!content.session && !frame.in_order.is_linked() && !frame.in_list.is_linked());
  if (content.state != Frame::State::kDetached)
    slots_[content.level->pager_slot].frames[content.block] = kNoId;
  if (content.addressed)
    pool_.unreserve(content.frame_bytes);
  else
    pool_.give_back(content.memory, content.frame_bytes);
  become(frame, Frame::State::kVacant);
  frame.content = {};
  vacant_.push_back(frame);
}

PLAIT_END_NAMESPACE
