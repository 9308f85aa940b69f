// Joins the halves of an edge to slots.
#pragma once

#include <cstddef>
#include <span>

#include "execution/fused/half_layout.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Both halves of an edge, and the addresses of its slots.
struct EdgeHalves {
  HalfBuffer own, other;
  std::byte* const* slots;  ///< [level - 1]
};

/// Copies the records of the piece at `offset` bytes in the halves to the slots of these edges.
/// `streaming` bypasses the caches, for memory that is not read again soon.
void merge_piece(const HalfPiece& piece, std::size_t offset, std::span<const EdgeHalves> edges,
                 bool streaming);

/// Writes the whole slot of a border edge: the records of the own face, row after row. `own` is the
/// address of the level in the half.
void pack_border_slot(std::size_t record_bytes, int level, const std::byte* own, std::byte* slot);

/// Makes streamed slots visible to other threads.
void finish_streaming();

PLAIT_END_NAMESPACE
