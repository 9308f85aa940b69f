// plait/detail/rows.h: the arguments of functions that compute rows of points of a group of
// patches.
//
// A point is [axis][lane]: kPointNumbers numbers. Steps and counts are in points. Rows are aligned
// to 64 bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/fused.h"

PLAIT_BEGIN_NAMESPACE

constexpr std::size_t kPointNumbers = 3 * kPatchLanes;

/// Each of A, B (the ends of an edge) and C, D (opposite the edge) points to the first of a row of
/// coarse points. The function computes every second fine point of `to`.
template <class Real>
struct OddRow {
  const Real *a, *b, *c, *d;
  Real* to;
  std::int64_t count;
};

/// The six neighbours of a row of points, in opposite pairs.
template <class Real>
struct Neighbours {
  const Real* pairs[3][2];
};

/// `v` is a row of coarse points. The function writes their new positions to every second fine
/// point of `to`.
template <class Real>
struct EvenRow {
  const Real* v;
  Neighbours<Real> neighbours;
  Real* to;
  std::int64_t count;
};

/// Points at distance `step` in one lattice, and the same points of an output.
template <class Real, class Output>
struct SurfaceRow {
  const Real* v;
  Neighbours<Real> neighbours;
  Output* to;
  std::int64_t step, count;
};

/// Base vertices of one valence and their rings, one vertex in each lane: `from` at one level, `to`
/// at the next. Point 0 is the vertex. Its neighbours follow counterclockwise; at a border they go
/// from border to border. (For a rule that reads two rings, RingShape numbers the points.)
template <class Real>
struct RingStep {
  const Real* from;
  Real* to;
  int valence;
  bool border;
};

PLAIT_END_NAMESPACE
