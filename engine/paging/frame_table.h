// Which block is in which frame, and the memory of the frames: under one budget. Knows no session,
// no backend and no transfer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "paging/frame.h"
#include "paging/frame_pool.h"

namespace plait {

/// One thread at a time (the pager's lock). Only attach() allocates anything but memory for frames,
/// so that all else is noexcept in truth.
class FrameTable {
 public:
  explicit FrameTable(std::uint64_t budget_bytes) : pool_(budget_bytes) {}
  /// REQUIRES: every frame was vacated.
  ~FrameTable() = default;
  FrameTable(const FrameTable&) = delete;
  FrameTable& operator=(const FrameTable&) = delete;

  /// Makes entries for its blocks, and frames for as many as the budget can hold at once.
  /// Errors: std::bad_alloc, with nothing changed.
  void attach(LevelFile& level);
  /// REQUIRES: none of its blocks is in a frame.
  void detach(LevelFile& level) noexcept;
  bool is_attached(const LevelFile& level) const noexcept { return level.pager_slot != kNoId; }
  /// The attached level of the attribute with this number, or nullptr.
  const LevelFile* level(std::uint32_t attribute, int number) const noexcept;

  static std::uint64_t frame_bytes(const LevelFile& level) {
    return FramePool::frame_bytes(level.geometry.max_block_bytes());
  }
  /// The frame that holds the block, in whatever state, or nullptr.
  Frame* find(const LevelFile& level, std::uint64_t block) noexcept;
  /// A frame for a block that has none, in State::kClaimed; nullptr: the budget has no room. With
  /// an `address` that is its memory. Errors: std::bad_alloc, with nothing changed.
  Frame* claim(const LevelFile& level, std::uint64_t block, std::byte* address);
  /// The block is in no frame any more; this one keeps its memory until vacate().
  void detach_block(Frame& frame) noexcept;
  /// The frame, its links undone, holds no block any more.
  void vacate(Frame& frame) noexcept;

  FramePool& pool() { return pool_; }
  const FramePool& pool() const { return pool_; }
  Frame& operator[](std::uint32_t index) { return frames_[index]; }
  /// All of them, vacant ones too. A deque, because frames stay where they are.
  std::deque<Frame>& frames() { return frames_; }

 private:
  struct Slot {
    const LevelFile* level = nullptr;
    std::vector<std::uint32_t> frames;  ///< [block] index or kNoId
  };
  std::uint64_t most_frames(const LevelFile& added) const noexcept;

  FramePool pool_;
  std::deque<Frame> frames_;
  FrameList vacant_;
  std::vector<Slot> slots_;  ///< [pager slot]
};

}  // namespace plait
