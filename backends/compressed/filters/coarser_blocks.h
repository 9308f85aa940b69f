// backends/compressed/filters/coarser_blocks.h: chooses the blocks of coarser levels from which the
// vertices of a block are predicted. The choice depends on the base mesh, on the depths of its
// faces and on the sizes of blocks only, so a reader makes the same choice as the writer did.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/face_depths.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The largest number of blocks that one block is predicted from (docs/filters/hierarchy.md).
inline constexpr std::size_t kMostCoarserBlocks = 16;
static_assert(kMostCoarserBlocks + kMostSourceBlocks <= kMostContextBlocks);

/// A block of the level that is refined `refinement` times from the base mesh.
struct CoarserBlock {
  int refinement = 0;
  std::uint64_t block = 0;
};

/// The blocks that one block is predicted from, in the order of levels, coarser ones first.
struct CoarserChoice {
  std::array<CoarserBlock, kMostCoarserBlocks> blocks = {};
  std::size_t count = 0;
  EdgeId own_edge = 0;  ///< the first edge with a slot in the block that is predicted
};

/// Immutable and safe from any number of threads.
class CoarserBlocks {
 public:
  /// The coarsest levels of an attribute: levels[i] is refined i + 1 times. `own` is the next finer
  /// level, whose blocks are predicted. `depths` is null if all faces have all levels. The
  /// referenced objects outlive this object. Errors: kNotSupported if there are more levels than a
  /// block may have context.
  CoarserBlocks(const Topology& mesh, const FaceDepths* depths,
                std::vector<const LevelGeometry*> levels, const LevelGeometry& own);
  ~CoarserBlocks();
  CoarserBlocks(const CoarserBlocks&) = delete;
  CoarserBlocks& operator=(const CoarserBlocks&) = delete;

  /// Of each coarser level, the block with the first slot's edge of `block`; and of all levels
  /// together, as many more as a block may have context: those with most of the vertices around,
  /// which are in the slots of the faces at the block's edges and of the next faces. The first call
  /// for a block takes about as long as reading the slots of its edges; the choice is kept for
  /// later calls.
  CoarserChoice choose(std::uint64_t block) const noexcept;

  const Topology& mesh() const noexcept { return mesh_; }
  const FaceDepths* depths() const noexcept { return depths_; }
  const LevelGeometry& own() const noexcept { return *own_; }
  const LevelGeometry& level(int refinement) const noexcept {
    return *levels_[static_cast<std::size_t>(refinement - 1)];
  }

 private:
  CoarserChoice compute(std::uint64_t block) const noexcept;

  Topology mesh_;
  const FaceDepths* depths_;
  std::vector<const LevelGeometry*> levels_;
  const LevelGeometry* own_;
  mutable std::vector<std::atomic<const CoarserChoice*>> kept_;  ///< [block] or null
};

/// The slots of the chosen blocks, as the pager hands them over.
class CoarserSlots {
 public:
  /// REQUIRES: context[i] are the bytes of choice.blocks[i].
  CoarserSlots(const CoarserBlocks& blocks, const CoarserChoice& choice,
               std::span<const std::span<const std::byte>> context) noexcept;

  /// The slot of an edge; its bytes are null if it is absent or in no chosen block.
  struct Found {
    const std::byte* bytes = nullptr;
    SlotShape shape = SlotShape::kWhole;
  };
  /// At the level with this refinement.
  Found slot(int refinement, EdgeId edge) const noexcept {
    const Slot slot = blocks_.level(refinement).slot(edge);
    if (slot.shape == SlotShape::kAbsent) [[unlikely]]
      return {nullptr, slot.shape};
    const auto at = static_cast<std::size_t>(refinement);
    for (std::size_t i = begin_[at - 1]; i < begin_[at]; ++i)
      if (edge >= parts_[i].first && edge < parts_[i].end)
        return {parts_[i].bytes + (slot.offset - parts_[i].offset), slot.shape};
    return {nullptr, slot.shape};
  }

 private:
  /// A chosen block: its edges, its bytes, and its place in its level.
  struct ChosenBlock {
    EdgeId first = 0, end = 0;
    const std::byte* bytes = nullptr;
    std::uint64_t offset = 0;
  };

  const CoarserBlocks& blocks_;
  std::array<ChosenBlock, kMostCoarserBlocks> parts_ = {};
  std::array<std::size_t, kMostCoarserBlocks + 1> begin_ =
      {};  ///< [refinement] the end of its parts
};

PLAIT_END_NAMESPACE
