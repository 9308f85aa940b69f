// The arithmetic of a refined group of patches, a row at a time, as a table of functions: compiled
// once for each instruction set, chosen when the program runs.
//
// A point is [axis][lane]: kPointNumbers numbers. Steps and counts are in points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/fused.h"
#include "plait/vector3.h"

namespace plait::fused_rows {

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

/// Base vertices of one valence and their rings, a vertex in each lane: the vertex itself, then its
/// `valence` neighbours counterclockwise, on a border from border to border.
template <class Real>
struct FanStep {
  const Real* from;
  Real* to;
  int valence;
  bool border;
};

template <class Real>
struct PatchRows {
  void (*odd)(const OddRow<Real>&);
  void (*even)(const EvenRow<Real>&);
  void (*limit)(const SurfaceRow<Real, Real>&);
  void (*normal)(const SurfaceRow<Real, float>&);
  void (*fan)(const FanStep<Real>&);
  /// Where an even vertex on a border goes, from its two new neighbours along it.
  Vector3<Real> (*border)(const Vector3<Real>& v, const Vector3<Real>& a, const Vector3<Real>& b);
};

}  // namespace plait::fused_rows
