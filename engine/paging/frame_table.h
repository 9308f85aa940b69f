// Tells which block is in which frame, and owns the memory of the frames under one budget. This
// class does not use sessions, backends or transfers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "paging/frame.h"
#include "paging/frame_pool.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager's lock protects everything except look_up(). Only attach() and find_needed_until()
/// allocate memory other than that of frames, so the noexcept functions never fail.
class FrameTable {
 public:
  explicit FrameTable(std::uint64_t budget_bytes) : pool_(budget_bytes) {}
  /// REQUIRES: every frame is vacant.
  ~FrameTable() = default;
  FrameTable(const FrameTable&) = delete;
  FrameTable& operator=(const FrameTable&) = delete;

  /// Makes entries for the blocks of the level, and enough frames for all blocks that can be in
  /// memory at once. Errors: std::bad_alloc, without any change.
  void attach(LevelFile& level);
  /// REQUIRES: no block of the level is in a frame.
  void detach(LevelFile& level) noexcept;
  bool is_attached(const LevelFile& level) const noexcept { return level.pager_slot != kNoId; }
  /// Finds how long blocks are needed, if levels were attached since the last call. Errors:
  /// std::bad_alloc.
  void find_needed_until();
  /// The last edge for which other blocks are decoded from this one, as far as that is known.
  EdgeId needed_until(const LevelFile& level, std::uint64_t block) const noexcept {
    const std::vector<EdgeId>& until = slots_[level.pager_slot].needed_until;
    return until.empty() ? kNoId : until[block];
  }
  /// The attached level of the attribute with this number, or nullptr.
  const LevelFile* level(std::uint32_t attribute, int number) const noexcept;

  static std::uint64_t frame_bytes(const LevelFile& level) {
    return FramePool::frame_bytes(level.geometry.max_block_bytes());
  }
  /// The same as find(), without the lock: the frame may get another block at any time.
  static Frame* look_up(const LevelFile& level, std::uint64_t block) noexcept {
    return level.frames[block].load(std::memory_order_acquire);
  }
  /// The frame of the block, in any state, or nullptr.
  Frame* find(const LevelFile& level, std::uint64_t block) noexcept;
  /// Returns a frame in State::kClaimed for a block that has none, or nullptr if the budget has no
  /// room. The memory of the frame is at `address`, unless that is nullptr. Errors: std::bad_alloc,
  /// without any change.
  Frame* claim(const LevelFile& level, std::uint64_t block, std::byte* address);
  /// After this call find() does not find the block. The frame keeps its memory until vacate().
  void detach_block(Frame& frame) noexcept;
  /// Frees the memory of the frame, which is then vacant. REQUIRES: the frame has no pins, and is
  /// in no list.
  void vacate(Frame& frame) noexcept;

  FramePool& pool() { return pool_; }
  const FramePool& pool() const { return pool_; }
  Frame& operator[](std::uint32_t index) { return frames_[index]; }
  /// All frames, including vacant ones. A deque, because frames must not move.
  std::deque<Frame>& frames() { return frames_; }

 private:
  struct LevelFrames {
    const LevelFile* level = nullptr;
    std::unique_ptr<std::atomic<Frame*>[]> frames;  ///< [block] or nullptr
    std::vector<EdgeId> needed_until;               ///< [block], or empty
  };
  std::uint64_t most_frames(const LevelFile& added) const noexcept;
  void forget_block(const Frame& frame) noexcept;

  FramePool pool_;
  std::deque<Frame> frames_;
  FrameList vacant_;
  std::vector<LevelFrames> slots_;  ///< [pager slot]
  bool has_new_levels_ = false;
};

PLAIT_END_NAMESPACE
