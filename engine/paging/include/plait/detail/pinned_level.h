// plait/detail/pinned_level.h: the blocks of one level that a walk over the mesh has pinned. They
// are found by edge.
//
// A walk (an executor, a copy, an export) has one PinnedLevel for each level that it works on, and
// goes in steps. In each step it says which edges it needs, and one call pins the blocks of these
// edges on all levels. Blocks of earlier steps stay pinned until the walk releases them. Pinned by
// tests/engine/paging/pinned_level_test.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <list>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/session.h"

PLAIT_BEGIN_NAMESPACE

/// Threads: one at a time, but slot() may run while another thread needs, pins and releases other
/// blocks (docs/threads.md). Must not outlive the level. If an exception destroys this object, it
/// abandons its pins, and a level that it wrote to stays unfinished.
class PinnedLevel {
 public:
  /// Opens the level for reading.
  explicit PinnedLevel(const LevelFile& file) : PinnedLevel(file, nullptr, Access::kRead) {}
  /// With Access::kOverwrite, the first pin of a block overwrites it, and later ones update it.
  PinnedLevel(LevelFile& file, Access access)
      : PinnedLevel(file, access == Access::kRead ? nullptr : &file, access) {}
  ~PinnedLevel();
  PinnedLevel(PinnedLevel&&) noexcept = default;
  PinnedLevel& operator=(PinnedLevel&&) = delete;

  const LevelGeometry& geometry() const { return file_->geometry; }
  int run_log2() const { return file_->run_log2; }  ///< LevelFile::run_log2

  /// Begins a step, which needs no blocks at first.
  void begin_step() noexcept {
    ++step_;
    needed_.clear();
  }
  /// Tells that the step needs the block of this edge.
  void need(EdgeId edge) { need_block(geometry().block_of(edge)); }
  void need_block(std::uint64_t block) {
    if (blocks_[block].needed_in != step_) mark_needed(block);
  }
  /// Tells that the step needs, on this level, all edges of the blocks that it needs on the level
  /// `other` of the same mesh.
  void need_edges_of(const PinnedLevel& other);

  /// Pins all needed blocks of these levels that are not pinned yet, in one call. After an error it
  /// has pinned none of them. Errors: those of Session::pin_many.
  static void pin_needed(Session& session, std::span<PinnedLevel> levels);
  /// Prefetches the block of this edge (Session::prefetch), unless it did so before. Returns false
  /// if the session has no free frame at the moment.
  bool announce(Session& session, EdgeId edge) noexcept {
    const std::uint64_t block = geometry().block_of(edge);
    return announced_.empty() || announced_[block] || announce_block(session, block);
  }
  /// Whether announce() has any effect: not for a level in memory, nor for one that is overwritten.
  bool can_be_announced() const noexcept { return !announced_.empty(); }

  /// The slot of an edge in memory. REQUIRES: its block is pinned.
  LocatedSlot slot(EdgeId edge) const noexcept {
    const Slot slot = geometry().slot(edge);
    const std::uintptr_t start = starts_[geometry().block_of(edge)];
    return {{reinterpret_cast<std::byte*>(start + slot.offset), slot.bytes}, slot.shape};
  }
  bool is_pinned(EdgeId edge) const noexcept { return is_block_pinned(geometry().block_of(edge)); }
  bool is_block_pinned(std::uint64_t block) const noexcept { return starts_[block] != 0; }

  /// Ends the pin of the block of this edge, or of a block. REQUIRES: it is pinned.
  void release(EdgeId edge) noexcept { release_block(geometry().block_of(edge)); }
  void release_block(std::uint64_t block) noexcept;
  /// Ends the pins of blocks that the step does not need.
  void release_rest() noexcept {
    while (has_rest()) release_oldest();
  }
  /// Whether blocks are pinned that the step does not need.
  bool has_rest() const noexcept { return !pins_.empty() && oldest_step() != step_; }
  /// The oldest block is the one that no step has needed for the longest time. Returns the last
  /// step that needed it. REQUIRES for this and for release_oldest(): a block is pinned.
  std::uint32_t oldest_step() const noexcept { return blocks_[pins_.front().block].needed_in; }
  void release_oldest() noexcept { release_block(oldest_block()); }
  std::uint64_t oldest_block() const noexcept { return pins_.front().block; }

  /// Bytes of one frame; of the frames of all needed blocks; of all pinned blocks; of the blocks
  /// that are needed but not pinned.
  std::uint64_t frame_bytes() const noexcept { return frame_bytes_; }
  std::uint64_t needed_bytes() const noexcept { return needed_.size() * frame_bytes_; }
  std::uint64_t pinned_bytes() const noexcept { return pins_.size() * frame_bytes_; }
  std::uint64_t missing_bytes() const noexcept;

 private:
  struct Pin {
    std::uint64_t block;
    PinnedBlock pinned;
  };
  struct Block {
    std::uint32_t needed_in = 0;  ///< the last step that needs it
    bool was_pinned = false;
    std::list<Pin>::iterator pin;
  };

  PinnedLevel(const LevelFile& file, LevelFile* written, Access access);
  void mark_needed(std::uint64_t block);
  BlockRequest request(std::uint64_t block) const;
  bool announce_block(Session& session, std::uint64_t block) noexcept;

  const LevelFile* file_;
  LevelFile* written_;  ///< the same level, or nullptr for reading
  Access access_;
  std::uint64_t frame_bytes_;
  /// [block] the address of the block in its frame minus its offset in the level, so that adding an
  /// offset gives an address; 0 while the block is not pinned.
  std::vector<std::uintptr_t> starts_;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> needed_;  ///< blocks
  std::vector<bool> announced_;        ///< [block]; empty if the access reads no blocks
  std::list<Pin> pins_;                ///< the oldest first: see oldest_step()
  std::uint32_t step_ = 1;
  int exceptions_ = std::uncaught_exceptions();  ///< when this object was made
};

PLAIT_END_NAMESPACE
