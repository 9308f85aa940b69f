// backends/compressed/filters/slot_rows.h: how filters that work inside a slot walk over a block.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The grid of one slot, in records. Row r of a whole slot has `side` records; row r of a half slot
/// has side - r, because the others belong to a face that is not there.
struct SlotGrid {
  std::size_t first;  ///< the slot's first record, counted from the block's
  std::size_t side;   ///< rows
  bool half;

  std::size_t row_records(std::size_t row) const noexcept { return half ? side - row : side; }
};

/// Calls visit(SlotGrid) for each slot of the block that is not absent, in the order of the block.
template <class Visit>
void for_each_slot(const LevelGeometry& geometry, std::uint64_t block, Visit visit) {
  const auto side = static_cast<std::size_t>(slot_side(geometry.level().refinements));
  const std::uint64_t before = geometry.block_offset(block);
  const EdgeId last = geometry.edge_after(block);
  for (EdgeId edge = geometry.first_edge(block); edge < last; ++edge) {
    const Slot slot = geometry.slot(edge);
    if (slot.shape != SlotShape::kAbsent)
      visit(SlotGrid{static_cast<std::size_t>((slot.offset - before) / geometry.record_bytes()),
                     side, slot.shape == SlotShape::kHalf});
  }
}

PLAIT_END_NAMESPACE
