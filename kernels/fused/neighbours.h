// Finds the rows of the six neighbours of a row of points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fused/lattice_buffer.h"
#include "fused/patch_sides.h"
#include "plait/detail/rows.h"
#include "plait/extend/fused.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pairs of opposite neighbours, in the order of the frame of `side`.
template <class Real>
inline Neighbours<Real> neighbours(const Real* numbers, const PatchLattice& lattice, std::int64_t i,
                                   std::int64_t j, int side) {
  const int start = (side + 1) % 3, end = (side + 2) % 3;
  const auto pair = [&](LatticeStep s, std::size_t which, Neighbours<Real>& to) {
    to.pairs[which][0] = lattice_points::at(numbers, lattice, i + s.i, j + s.j);
    to.pairs[which][1] = lattice_points::at(numbers, lattice, i - s.i, j - s.j);
  };
  Neighbours<Real> result;
  pair(step(start, side), 0, result);
  pair(step(end, side), 1, result);
  pair(step(end, start), 2, result);
  return result;
}

PLAIT_END_NAMESPACE
