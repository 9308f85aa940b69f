// From halves to slots.
#pragma once

#include <cstddef>
#include <span>

#include "execution/fused/half_layout.h"

namespace plait {

/// Both halves of an edge, and where its slots begin.
struct SlotHalves {
  HalfBuffer own, other;
  std::byte* const* slots;  ///< [level - 1]
};

/// Puts the records of a piece, `offset` bytes into the halves, into the slots of these edges.
/// `streaming` bypasses the caches: for memory that is not read again soon.
void merge_piece(const HalfPiece& piece, std::size_t offset, std::span<const SlotHalves> edges,
                 bool streaming);

/// The records of the own face alone, row after row: a border edge's slot, whole. `own` is to where
/// the level begins in the half.
void pack_border_slot(std::size_t record_bytes, int level, const std::byte* own, std::byte* slot);

/// Makes streamed slots visible to other threads.
void finish_streaming();

}  // namespace plait
