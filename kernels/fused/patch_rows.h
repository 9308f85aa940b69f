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

/// Base vertices of one valence and their rings, a vertex in each lane, numbered as FanShape says.
template <class Real>
struct FanStep {
  const Real* from;
  Real* to;
  int valence;
  bool border;
};

/// What every rule has.
template <class Real>
struct PatchRows {
  void (*limit)(const SurfaceRow<Real, Real>&);
  void (*normal)(const SurfaceRow<Real, float>&);
  void (*fan)(const FanStep<Real>&);
};

/// A rule whose new vertices depend on a one-ring.
template <class Real>
struct OneRingRows : PatchRows<Real> {
  void (*odd)(const OddRow<Real>&);
  void (*even)(const EvenRow<Real>&);
  /// Where an even vertex on a border goes, from its two new neighbours along it.
  Vector3<Real> (*border)(const Vector3<Real>& v, const Vector3<Real>& a, const Vector3<Real>& b);
};

/// Points A, B, C, D as in OddRow and the wings: over the edges AC, DB, CB and AD.
template <class Real>
struct WingedRow {
  const Real *a, *b, *c, *d, *wing_ac, *wing_db, *wing_cb, *wing_ad;
  Real* to;
  std::int64_t count;
};

template <class Real>
struct ButterflyRows : PatchRows<Real> {
  void (*odd)(const WingedRow<Real>&);
  void (*even)(const EvenRow<Real>&);  ///< looks at no neighbours
};

}  // namespace plait::fused_rows
