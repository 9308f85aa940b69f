// Copies the lanes of a group of patches to pieces of halves.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "execution/fused/half_layout.h"
#include "plait/extend/fused.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// [lane] the address of its piece.
using LanePieces = std::array<std::byte*, kPatchLanes>;

/// `points` is the result of PatchRefiner::points() for this output.
void scatter_piece(const HalfOutput& output, const void* points, std::span<const HalfMove> moves,
                   const LanePieces& to);

PLAIT_END_NAMESPACE
