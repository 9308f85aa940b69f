// plait/kernels/rows.h: rows of points of a refined group of patches, and what is made of them.
//
// A point is [axis][lane]: kPointNumbers numbers. Steps and counts are in points. Rows are aligned
// to 64 bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/fused.h"

namespace plait {

constexpr std::size_t kPointNumbers = 3 * kPatchLanes;

/// Points A, B (ends of an edge) and C, D (opposite it), each the first of a row of coarse points;
/// every second fine point of `to` is made.
template <class Real>
struct OddRow {
  const Real *a, *b, *c, *d;
  Real* to;
  std::int64_t count;
};

/// The six neighbours of a row of points in opposite pairs.
template <class Real>
struct Neighbours {
  const Real* pairs[3][2];
};

/// `v`, a row of coarse points, moves to every second fine point of `to`.
template <class Real>
struct EvenRow {
  const Real* v;
  Neighbours<Real> neighbours;
  Real* to;
  std::int64_t count;
};

/// Points `step` apart in one lattice, and the same points of an output.
template <class Real, class Output>
struct SurfaceRow {
  const Real* v;
  Neighbours<Real> neighbours;
  Output* to;
  std::int64_t step, count;
};

/// Base vertices of one valence and their rings, a vertex in each lane: `from` at one level, `to`
/// at the next. Point 0 is the vertex; its neighbours follow counterclockwise, on a border from
/// border to border. (The rings of a rule that reads two of them are numbered by RingShape.)
template <class Real>
struct RingStep {
  const Real* from;
  Real* to;
  int valence;
  bool border;
};

}  // namespace plait
