// sample/sample_ring.h: the small triangles around a sample, and how closely they follow the scan.
#pragma once

#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A point of the scan and the scan's normal there.
struct OrientedPoint {
  Point position{}, normal{};
};

/// What the triangles around a sample would be with the sample at some place.
struct RingEstimate {
  double error = 0;       ///< of the squared distances between the triangles and the scan, by area
  double least_turn = 1;  ///< cosine between a triangle's normal and the scan's
  double most_ratio = 1;  ///< of a triangle's area and the mean one, or the other way around
};

/// The small triangles around one sample. Between two points p and q with the normals m and n, the
/// estimate takes the scan for a smooth curve, which is (m - n) (q - p) / 8 from its chord. Pinned
/// by tests/scans/relax_test.cpp.
class SampleRing {
 public:
  void clear() { triangles_.clear(); }
  /// A triangle of the sample and two others. `mean_area` is that of the small triangles of its
  /// base face, twice, as area_vector() has it.
  void add(const OrientedPoint& second, const OrientedPoint& third, double mean_area);
  /// With the sample at `at`.
  RingEstimate estimate(const OrientedPoint& at) const;

 private:
  /// Has what does not depend on the sample.
  struct Triangle {
    OrientedPoint second, third;
    double squared_side, side_error, mean_area;
  };
  std::vector<Triangle> triangles_;
};

PLAIT_END_NAMESPACE
