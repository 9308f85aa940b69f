// The bounding box of all positions of a store.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PositionBox {
  Vector3<double> low{1, 1, 1}, high{-1, -1, -1};  ///< empty
  bool begun = false, finite = true;

  void add(const Vector3<double>& at) {
    if (!begun) low = high = at;
    begun = true;
    finite = finite && std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  void add(const PositionBox& other) {
    if (!other.begun) return;
    add(other.low);
    add(other.high);
    finite = finite && other.finite;
  }
  double diagonal() const {
    const Vector3<double> size = high - low;
    return std::sqrt(dot(size, size));
  }
  /// Whether lengths can count in diagonals.
  bool has_extent() const { return diagonal() > 0 && std::isfinite(diagonal()); }
};

/// Visits all positions, whose numbers are `Real`s. Errors: those of visit_vertices().
template <class Real>
PositionBox measure_positions(Store& store, const VisitOptions& options) {
  // Each thread has a box in a cache line of its own.
  struct alignas(64) BoxOfThread {
    PositionBox box;
  };
  std::vector<BoxOfThread> boxes(static_cast<std::size_t>(options.threads));
  visit_vertices(store, options, std::tuple{reads<Vector3<Real>>("position")},
                 [&](const VertexRun& run, std::span<const Vector3<Real>> position) {
                   PositionBox& box = boxes[static_cast<std::size_t>(run.worker)].box;
                   for (const Vector3<Real>& at : position) box.add(widen(at));
                 });
  PositionBox all;
  for (const BoxOfThread& one : boxes) all.add(one.box);
  return all;
}

PLAIT_END_NAMESPACE
