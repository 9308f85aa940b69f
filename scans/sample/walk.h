// sample/walk.h: straight ways along a scan.
#pragma once

#include <array>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Straight ways from one point of a scan, in any direction. `scan` must outlive this object.
/// Pinned by tests/scans/walk_test.cpp.
class Walk {
 public:
  Walk(const Surface& scan, const SurfacePoint& start);

  /// The point that is reached by going by the vector `way`: from face to face, the rest of the way
  /// turned into the next face's plane. It ends at a border, and at a face without area. The part
  /// of `way` that is at right angles to the first face does not count.
  SurfacePoint along(Point way) const;

 private:
  SurfacePoint across(std::array<double, 3> change) const;

  const Surface& scan_;
  SurfacePoint start_;
  std::array<Point, 3> gradients_;  ///< of the barycentric coordinates
};

/// The same for one way.
inline SurfacePoint walk(const Surface& scan, const SurfacePoint& start, Point way) {
  return Walk(scan, start).along(way);
}

PLAIT_END_NAMESPACE
