// backends/compressed/filters/predicting_filter.h: what the filters that predict a block from other
// levels have in common: the blocks that they need, and the lattice of each slot.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/default_arithmetic.h"
#include "compressed/filters/edge_lattice.h"
#include "plait/error.h"
#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A filter that reads records of `kComponents` numbers.
template <class Number, std::size_t kComponents>
class PredictingFilter : public Filter {
 public:
  bool needs_other_blocks() const noexcept final { return true; }
  std::uint32_t base_attribute() const noexcept final { return attribute_; }

  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept final {
    if (!blocks_) return 0;
    const CoarserChoice choice = blocks_->choose(block);
    for (std::size_t i = 0; i < choice.count; ++i)
      blocks[i] = {attribute_, base_level_ + choice.blocks[i].refinement, choice.blocks[i].block};
    return choice.count;
  }
  std::size_t scratch_bytes() const noexcept override { return lattice_bytes(); }

 protected:
  using Lattice = EdgeLattice<Number, kComponents>;

  /// Reads the coarsest `count` levels of `source`, and its base records. Without this call, the
  /// level's surroundings are not known.
  void read(const FilterLevel& level, const AttributeLevels& source, std::size_t count) {
    attribute_ = source.number;
    base_level_ = level.surroundings->base_level;
    base_ = source.base;
    const std::span levels = std::span(source.levels).first(count);
    blocks_.emplace(level.surroundings->mesh, level.surroundings->depths,
                    std::vector(levels.begin(), levels.end()), *level.geometry);
    places_.emplace(static_cast<int>(count) + 1, kComponents * sizeof(Number));
  }

  /// The memory of a lattice; 0 if the surroundings are not known.
  std::size_t lattice_bytes() const noexcept {
    return places_ ? Lattice::bytes(places_->grid().level + 1) : 0;
  }
  /// The level whose blocks are predicted. REQUIRES: read().
  const LevelGeometry& own() const noexcept { return blocks_->own(); }

  /// Calls visit(lattice, slot, where the slot begins in the block) for every `step`-th slot of the
  /// block that is not absent. Errors: kNotSupported if the surroundings are not known.
  template <class Visit>
  void visit_lattices(const FilterBlock& block, EdgeId step, bool has_wings, Visit visit) const {
    if (!blocks_)
      throw Error(ErrorCode::kNotSupported,
                  "predict a block from other levels: the mesh and these levels are not known");
    const DefaultArithmetic arithmetic;
    const CoarserChoice choice = blocks_->choose(block.block);
    const CoarserSlots slots(*blocks_, choice, block.context);
    const EdgesOfBlock edges(own(), block.block, step);
    Lattice lattice(*blocks_, slots, *places_, base_, block.scratch, edges, has_wings);
    const std::uint64_t start = own().block_offset(block.block);
    while (lattice.next()) {
      const Slot slot = own().slot(lattice.edge());
      visit(lattice, slot, slot.offset - start);
    }
  }

 private:
  std::uint32_t attribute_ = kNoId;
  int base_level_ = 0;
  std::span<const std::byte> base_;
  std::optional<CoarserBlocks> blocks_;
  std::optional<LatticePlaces> places_;
};

PLAIT_END_NAMESPACE
