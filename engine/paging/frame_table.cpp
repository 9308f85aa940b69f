#include "paging/frame_table.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "paging/needed_until.h"

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
  level.run_log2 = level.traits.moves_runs ? most_run_log2(level.geometry) : 0;
  slot->frames = std::make_unique<std::atomic<Frame*>[]>(level.geometry.block_count());
  slot->level = &level;
  has_new_levels_ = true;
  level.frames = slot->frames.get();
  level.pager_slot = static_cast<std::uint32_t>(slot - slots_.begin());
}

void FrameTable::detach(LevelFile& level) noexcept {
  LevelFrames& slot = slots_[level.pager_slot];
  assert(std::ranges::none_of(std::span(slot.frames.get(), level.geometry.block_count()),
                              [](const std::atomic<Frame*>& frame) { return frame.load(); }));
  slot.level = nullptr;
  slot.frames.reset();
  slot.needed_until.clear();
  level.frames = nullptr;
  level.pager_slot = kNoId;
}

void FrameTable::find_needed_until() {
  if (!has_new_levels_) return;
  std::vector<NeededLevel> levels;
  for (const LevelFrames& slot : slots_)
    if (slot.level) levels.push_back({slot.level, {}});
  plait::find_needed_until(levels);
  for (NeededLevel& found : levels)
    slots_[found.level->pager_slot].needed_until = std::move(found.until);
  has_new_levels_ = false;
}

const LevelFile* FrameTable::level(std::uint32_t attribute, int number) const noexcept {
  for (const LevelFrames& slot : slots_)
    if (slot.level && slot.level->table.attribute() == attribute &&
        slot.level->table.level() == number)
      return slot.level;
  return nullptr;
}

Frame* FrameTable::find(const LevelFile& level, std::uint64_t block) noexcept {
  return slots_[level.pager_slot].frames[block].load(std::memory_order_relaxed);
}

void FrameTable::forget_block(const Frame& frame) noexcept {
  const Frame::Content& content = frame.content;
  slots_[content.level->pager_slot].frames[content.block].store(nullptr, std::memory_order_release);
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
  frame.transfer.run_log2 = level.run_log2;
  frame.transfer.block = block;
  frame.transfer.memory = {memory, content.block_bytes};
  frame.transfer.tag = frame.index;
  slots_[level.pager_slot].frames[block].store(&frame, std::memory_order_release);
  return &frame;
}

void FrameTable::detach_block(Frame& frame) noexcept {
  become(frame, Frame::State::kDetached);
  forget_block(frame);
}

void FrameTable::vacate(Frame& frame) noexcept {
  const Frame::Content& content = frame.content;
  [[maybe_unused]] const bool has_no_pins = frame.pins.close();
  assert(has_no_pins && content.context_count == 0);
  assert(!content.session && !frame.in_order.is_linked() && !frame.in_list.is_linked());
  if (content.state != Frame::State::kDetached) forget_block(frame);
  if (content.addressed)
    pool_.unreserve(content.frame_bytes);
  else
    pool_.give_back(content.memory, content.frame_bytes);
  become(frame, Frame::State::kVacant);
  frame.pins.end_block();
  frame.content = {};
  vacant_.push_back(frame);
}

PLAIT_END_NAMESPACE
