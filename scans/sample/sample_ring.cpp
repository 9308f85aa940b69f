#include "sample/sample_ring.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A share of the length of an edge that counts as distance: keeps flat parts evenly sampled.
constexpr double kEvenShare = 0.02;
/// Area of a needle, as a share of its squared sides.
constexpr double kNeedleShare = 0.05;

double chord_error(const OrientedPoint& p, const OrientedPoint& q) {
  const Point along = q.position - p.position;
  const double height = dot(p.normal - q.normal, along) / 8;
  return height * height + kEvenShare * kEvenShare * squared_length(along);
}

}  // namespace

void SampleRing::add(const OrientedPoint& second, const OrientedPoint& third, double mean_area) {
  triangles_.push_back({second, third, squared_length(third.position - second.position),
                        chord_error(second, third), mean_area});
}

RingEstimate SampleRing::estimate(const OrientedPoint& at) const {
  RingEstimate result;
  for (const Triangle& t : triangles_) {
    const Point normal = area_vector(at.position, t.second.position, t.third.position);
    const Point expected = at.normal + t.second.normal + t.third.normal;
    const double area = length(normal), lengths = area * length(expected);
    result.least_turn =
        std::min(result.least_turn, lengths > 0 ? dot(normal, expected) / lengths : -1);
    result.most_ratio = std::max(
        {result.most_ratio, area / t.mean_area, area > 0 ? t.mean_area / area : t.mean_area});
    const double squares = t.squared_side + squared_length(t.second.position - at.position) +
                           squared_length(t.third.position - at.position);
    result.error += std::max(area, kNeedleShare * squares) *
                    (t.side_error + chord_error(at, t.second) + chord_error(at, t.third));
  }
  return result;
}

PLAIT_END_NAMESPACE
