// sample/sample_ring.h: the small triangles around a sample, and how closely they follow the scan.
#pragma once

#include <optional>
#include <vector>

#include "plait/detail/namespace.h"
#include "sample/oriented_scan.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What the triangles around a sample would be with the sample at some place.
struct RingEstimate {
  double error = 0;       ///< of the squared distances between the triangles and the scan, by area
  double least_turn = 1;  ///< cosine between a triangle's normal and the scan's
  double most_ratio = 1;  ///< of a triangle's area and the mean one, or the other way around
};

/// Those that a new place for a sample has to keep.
struct RingLimits {
  double error, least_turn, most_ratio;
};

/// Of the squared distances between one small triangle and the scan, times `area` (SampleRing).
double triangle_error(const OrientedPoint& a, const OrientedPoint& b, const OrientedPoint& c,
                      double area);

/// The small triangles around one sample. Between two points p and q with the normals m and n, the
/// estimate takes the scan for a smooth curve, which is h = (m - n) (q - p) / 8 from the middle of
/// its chord. Over a triangle, the scan is the quadratic function with these h at the middles of
/// the three sides; the mean of its squares is 4/45 of the sum of the squares and the square of the
/// sum. Pinned by tests/scans/sample_ring_test.cpp.
class SampleRing {
 public:
  void clear() { triangles_.clear(); }
  /// A triangle of the sample and two others. `mean_area` is that of the small triangles of its
  /// base face, twice, as area_vector() has it.
  void add(const OrientedPoint& second, const OrientedPoint& third, double mean_area);
  /// With the sample at `at`.
  RingEstimate estimate(const OrientedPoint& at) const;
  /// The error with the sample at `at`; empty if it is not less than the limit, or if another limit
  /// is broken. Much faster than estimate().
  std::optional<double> error_within(const OrientedPoint& at, const RingLimits& limits) const;

 private:
  /// Has what does not depend on the sample.
  struct Triangle {
    OrientedPoint second, third;
    double squared_side, side_height, mean_area;
  };
  static double error_of(const Triangle& triangle, const OrientedPoint& at, double area);
  std::vector<Triangle> triangles_;
};

PLAIT_END_NAMESPACE
