// From halves to slots.
#pragma once

#include <cstddef>

#include "execution/half_layout.h"

namespace plait {

/// Puts the records of one part of a piece into a slot. Pointers are to where the piece begins in
/// each half, and to the beginning of the slot of the part's level. `streaming` bypasses the
/// caches: for memory that is not read again soon.
void merge_part(const HalfPiece& piece, const HalfPiece::Part& part, const std::byte* own,
                const std::byte* other, bool streaming, std::byte* slot);

/// The records of the own face alone, row after row: a border edge's slot, whole. `own` is to where
/// the level begins in the half.
void pack_border_slot(std::size_t record_bytes, int level, const std::byte* own, std::byte* slot);

/// Makes streamed slots visible to other threads.
void finish_streaming();

}  // namespace plait
