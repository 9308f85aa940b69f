#include "sample/sample_ring.h"

#include <algorithm>
#include <cmath>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A share of the length of an edge that counts as distance: keeps flat parts evenly sampled.
constexpr double kEvenShare = 0.02;
/// Area of a needle, as a share of its squared sides.
constexpr double kNeedleShare = 0.05;

/// How far the scan is from the middle of the chord.
double height_between(const OrientedPoint& p, const OrientedPoint& q) {
  return dot(p.normal - q.normal, q.position - p.position) / 8;
}

/// By the heights at the middles of the sides, and the sum of the squared sides.
double mean_square(double a, double b, double c, double squares, double area) {
  const double sum = a + b + c;
  return std::max(area, kNeedleShare * squares) *
         (a * a + b * b + c * c + sum * sum + kEvenShare * kEvenShare * squares);
}

double signed_square(double a) { return a * std::abs(a); }

}  // namespace

double triangle_error(const OrientedPoint& a, const OrientedPoint& b, const OrientedPoint& c,
                      double area) {
  const double squares = squared_length(b.position - a.position) +
                         squared_length(c.position - b.position) +
                         squared_length(a.position - c.position);
  return mean_square(height_between(a, b), height_between(b, c), height_between(c, a), squares,
                     area);
}

void SampleRing::add(const OrientedPoint& second, const OrientedPoint& third, double mean_area) {
  triangles_.push_back({second, third, squared_length(third.position - second.position),
                        height_between(second, third), mean_area});
}

double SampleRing::error_of(const Triangle& triangle, const OrientedPoint& at, double area) {
  const double squares = triangle.squared_side +
                         squared_length(triangle.second.position - at.position) +
                         squared_length(triangle.third.position - at.position);
  return mean_square(triangle.side_height, height_between(at, triangle.second),
                     height_between(at, triangle.third), squares, area);
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
    result.error += error_of(t, at, area);
  }
  return result;
}

std::optional<double> SampleRing::error_within(const OrientedPoint& at,
                                               const RingLimits& limits) const {
  const double least_squared_turn = signed_square(limits.least_turn);
  double error = 0;
  for (const Triangle& t : triangles_) {
    const Point normal = area_vector(at.position, t.second.position, t.third.position);
    const Point expected = at.normal + t.second.normal + t.third.normal;
    const double area = length(normal);
    if (!(area > 0) || area > limits.most_ratio * t.mean_area ||
        t.mean_area > limits.most_ratio * area)
      return {};
    if (signed_square(dot(normal, expected)) <
        least_squared_turn * area * area * squared_length(expected))
      return {};
    error += error_of(t, at, area);
    if (!(error < limits.error)) return {};
  }
  return error;
}

PLAIT_END_NAMESPACE
