// backends/compressed/filters/coarser_blocks.h: chooses the blocks of coarser levels from which the
// vertices of a block are predicted. The choice depends on the base mesh and on the sizes of blocks
// only, so a reader makes the same choice as the writer did.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/backend.h"
#include "plait/level_geometry.h"
#include "plait/namespace.h"
#include "plait/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A block of the level that is refined `refinement` times from the base mesh.
struct CoarserBlock {
  int refinement = 0;
  std::uint64_t block = 0;
};

/// The blocks that one block is predicted from, in the order of levels, coarser ones first.
struct CoarserChoice {
  std::array<CoarserBlock, kMostContextBlocks> blocks = {};
  std::size_t count = 0;
};

/// Immutable and safe from any number of threads.
class CoarserBlocks {
 public:
  /// The coarsest levels of an attribute: levels[i] is refined i + 1 times. `own` is the next finer
  /// level, whose blocks are predicted. The referenced objects outlive this object. Errors:
  /// kNotSupported if there are more levels than a block may have context.
  CoarserBlocks(const Topology& mesh, std::vector<const LevelGeometry*> levels,
                const LevelGeometry& own);

  /// Of each coarser level, the block with the edges of `block`, and the blocks that have most of
  /// the edges around: those of the faces at these edges, and of the next faces. Of the level
  /// before `own` up to most_of_last() blocks, of the others up to most_of_others().
  CoarserChoice choose(std::uint64_t block) const noexcept;
  std::size_t most_of_last() const noexcept { return most_of_last_; }
  std::size_t most_of_others() const noexcept { return most_of_others_; }

  const Topology& mesh() const noexcept { return mesh_; }
  const LevelGeometry& own() const noexcept { return *own_; }
  const LevelGeometry& level(int refinement) const noexcept {
    return *levels_[static_cast<std::size_t>(refinement - 1)];
  }

 private:
  Topology mesh_;
  std::vector<const LevelGeometry*> levels_;
  const LevelGeometry* own_;
  std::size_t most_of_last_ = 0, most_of_others_ = 0;
};

/// The slots of the chosen blocks, as the pager hands them over.
class CoarserSlots {
 public:
  /// REQUIRES: context[i] are the bytes of choice.blocks[i].
  CoarserSlots(const CoarserBlocks& blocks, const CoarserChoice& choice,
               std::span<const std::span<const std::byte>> context) noexcept
      : blocks_(blocks), choice_(choice), context_(context) {}

  /// The slot of an edge at the level with this refinement; null if it is in no chosen block.
  const std::byte* slot(int refinement, EdgeId edge) const noexcept {
    const LevelGeometry& level = blocks_.level(refinement);
    const std::uint64_t block = level.block_of(edge);
    for (std::size_t i = 0; i < choice_.count; ++i)
      if (choice_.blocks[i].block == block && choice_.blocks[i].refinement == refinement)
        return context_[i].data() + (level.slot(edge).offset - level.block_offset(block));
    return nullptr;
  }

 private:
  const CoarserBlocks& blocks_;
  const CoarserChoice& choice_;
  std::span<const std::span<const std::byte>> context_;
};

PLAIT_END_NAMESPACE
