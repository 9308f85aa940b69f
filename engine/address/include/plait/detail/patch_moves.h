// plait/detail/patch_moves.h: where the records of a patch go when the patch is copied from slots
// to row order. On coarse levels the rows of slots are so short that the loops over them, with
// their starts and ends, cost more than the copies. So these moves are listed once.
// Pinned by tests/engine/execution/reader_test.cpp.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A record of a whole slot, counted from the first record of the face's half, goes to `place` in
/// row order.
struct PatchMove {
  std::uint16_t record, place;
};

/// The lists of finer levels would take more of the first-level cache than the records.
constexpr int kMostListedMoves = 6;

/// The moves of a patch at `level`, without its corners: for each level from 1 on, the slots of
/// sides 0, 1 and 2, row after row. The list stays valid. Safe from several threads.
/// REQUIRES: 1 <= level <= kMostListedMoves.
const PatchMove* patch_moves(int level) noexcept;

PLAIT_END_NAMESPACE
