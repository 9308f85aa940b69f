// plait/pinned_level.h: the blocks of one level that a walk over the mesh has pinned, found by
// edge.
//
// Whoever walks (an executor, a copy, an export) has one PinnedLevel for each level that it works
// on and goes in steps. In each step it says which edges it needs; the blocks of these edges are
// pinned in one call for all levels. Blocks of earlier steps stay pinned until the walk releases
// them. Pinned by tests/engine/paging/pinned_level_test.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <list>
#include <span>
#include <vector>

#include "plait/session.h"

namespace plait {

/// One thread at a time; but slot() may be called while another thread needs, pins and releases
/// other blocks. Must not outlive the level. If an exception destroys this object, it abandons its
/// pins, and a level that it wrote to stays unfinished.
class PinnedLevel {
 public:
  /// For reading.
  explicit PinnedLevel(const LevelFile& file) : PinnedLevel(file, nullptr, Access::kRead) {}
  PinnedLevel(LevelFile& file, Access access)
      : PinnedLevel(file, access == Access::kRead ? nullptr : &file, access) {}
  ~PinnedLevel();
  PinnedLevel(PinnedLevel&&) noexcept = default;
  PinnedLevel& operator=(PinnedLevel&&) = delete;

  const LevelGeometry& geometry() const { return file_->geometry; }

  /// Begins a step: nothing is needed.
  void begin_step() noexcept {
    ++step_;
    needed_.clear();
  }
  /// The step needs the block of this edge.
  void need(EdgeId edge) { need_block(geometry().block_of(edge)); }
  /// The step needs the blocks of all edges of the needed blocks of `other`, which is a level of
  /// the same mesh.
  void need_edges_of(const PinnedLevel& other);

  /// Pins the needed blocks of all these levels that are not pinned, in one call. If it fails, none
  /// of them is pinned. Errors: those of Session::pin_many.
  static void pin_needed(Session& session, std::span<PinnedLevel> levels);
  /// Tells the session that the block of this edge will be read soon, unless it was told
  /// before. False: the session has no room at the moment.
  bool announce(Session& session, EdgeId edge) noexcept;

  /// The slot of an edge in memory. REQUIRES: its block is pinned.
  LocatedSlot slot(EdgeId edge) const noexcept {
    const Slot slot = geometry().slot(edge);
    const std::uintptr_t start = starts_[geometry().block_of(edge)];
    return {{reinterpret_cast<std::byte*>(start + slot.offset), slot.bytes}, slot.shape};
  }
  bool is_pinned(EdgeId edge) const noexcept { return starts_[geometry().block_of(edge)] != 0; }

  /// Ends the pin of the block of this edge. REQUIRES: it is pinned.
  void release(EdgeId edge) noexcept { release_block(geometry().block_of(edge)); }
  /// Ends the pins that the step does not need.
  void release_rest() noexcept {
    while (has_rest()) release_oldest();
  }
  /// Whether a block is pinned that the step does not need.
  bool has_rest() const noexcept { return !pins_.empty() && oldest_step() != step_; }
  /// The last step that needed the block whose need lies furthest back. REQUIRES: a block is
  /// pinned; release_oldest() too.
  std::uint32_t oldest_step() const noexcept { return blocks_[pins_.front().block].needed_in; }
  void release_oldest() noexcept { release_block(pins_.front().block); }

  /// Bytes of a frame, and of the frames of blocks that are needed, pinned, needed but not pinned.
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
    std::list<Pin>::iterator pin;
  };

  PinnedLevel(const LevelFile& file, LevelFile* written, Access access);
  void need_block(std::uint64_t block) {
    if (blocks_[block].needed_in != step_) mark_needed(block);
  }
  void mark_needed(std::uint64_t block);
  void release_block(std::uint64_t block) noexcept;

  const LevelFile* file_;
  LevelFile* written_;  ///< the same level, or nullptr for reading
  Access access_;
  std::uint64_t frame_bytes_;
  /// [block] the address that the level's first byte would have if all of it lay where the block
  /// does; 0 while the block is not pinned.
  std::vector<std::uintptr_t> starts_;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> needed_;  ///< blocks
  std::vector<bool> announced_;        ///< [block]; empty: nothing is read
  std::list<Pin> pins_;                ///< the one whose need lies furthest back first
  std::uint32_t step_ = 1;
  int exceptions_ = std::uncaught_exceptions();  ///< when this object was made
};

}  // namespace plait
