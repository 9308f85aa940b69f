// tests/acceptance/normal_bound.h: for each vertex, a bound of the angle between a normal computed
// from float32 positions and the true normal. The bound needs only the oracle's mesh.
// docs/kernels.md, "How exact are normals", derives it and uses the same names.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/naive_limit.h"
#include "support/naive_subdivision.h"

namespace plait::test {

/// One unit in the last place of a float32 number of this size.
inline double float_unit(double size) { return std::ldexp(1.0, std::ilogb(size) - 23); }

struct NormalBound {
  /// In radians; pi if float32 positions do not determine the normal at all.
  double angle = std::numbers::pi;
  /// kappa: 2.5 at a regular vertex with equilateral triangles. It grows when the tangents become
  /// parallel or vanish.
  double condition = INFINITY;
  double shortest_edge = 0;
  bool is_determined() const { return angle < std::numbers::pi; }
};

/// Bounds for every vertex of one mesh, which must outlive this object.
class NormalBounds {
 public:
  explicit NormalBounds(const naive::Mesh& mesh) : mesh_(mesh), rings_(mesh) {
    double largest = 0;
    for (const naive::Point& point : mesh.points)
      largest = std::max({largest, std::abs(point.x), std::abs(point.y), std::abs(point.z)});
    unit_ = float_unit(largest);
  }

  /// u: one unit in the last place of the largest coordinate.
  double unit() const { return unit_; }

  NormalBound at(naive::Index vertex) {
    constexpr double kEpsilon = 0x1p-24;
    const double sqrt3 = std::numbers::sqrt3;
    rings_.find(vertex, ring_);
    const Tangent first = tangent(vertex, 0), second = tangent(vertex, 1);
    NormalBound bound;
    bound.shortest_edge = shortest_edge(vertex);
    const double area = naive::length(naive::cross(first.direction, second.direction));
    const double length1 = naive::length(first.direction),
                 length2 = naive::length(second.direction);
    bound.condition =
        bound.shortest_edge * (first.weights * length2 + second.weights * length1) / area;

    const double position_error = sqrt3 * kUnitsPerLevel * mesh_.level * unit_;
    const double error1 = first.weights * position_error + 3 * kEpsilon * first.spread;
    const double error2 = second.weights * position_error + 3 * kEpsilon * second.spread;
    const double sine = (error1 * length2 + error2 * length1 + error1 * error2 +
                         2 * sqrt3 * kEpsilon * (length1 + error1) * (length2 + error2)) /
                        area;
    if (sine < 1) bound.angle = std::asin(sine) + 2 * kEpsilon;
    return bound;
  }

 private:
  /// By how much the error of a coordinate grows per level of Loop's rules in place, in units u.
  static constexpr double kUnitsPerLevel = 3.3;

  struct Tangent {
    naive::Point direction;
    double weights = 0;  ///< sum of the absolute weights
    double spread = 0;   ///< sum of absolute weight times distance of the neighbour
  };

  Tangent tangent(naive::Index vertex, int which) {
    const std::size_t n = ring_.neighbours.size();
    if (!ring_.closed && which == 1) border_weights_ = naive::border_tangent_weights(n);
    Tangent sum;
    double centre_weight = 0;
    for (std::size_t k = 0; k < n; ++k) {
      double weight;
      if (ring_.closed) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
        weight = which == 0 ? std::cos(angle) : std::sin(angle);
      } else {
        weight = which == 1 ? border_weights_[k + 1] : k == 0 ? 1 : k + 1 == n ? -1 : 0;
      }
      const naive::Point spoke = mesh_.points[ring_.neighbours[k]] - mesh_.points[vertex];
      sum.direction += weight * spoke;
      sum.weights += std::abs(weight);
      sum.spread += std::abs(weight) * naive::length(spoke);
      centre_weight -= weight;
    }
    sum.weights += std::abs(centre_weight);
    return sum;
  }

  double shortest_edge(naive::Index vertex) const {
    double shortest = INFINITY;
    for (const naive::Index neighbour : ring_.neighbours)
      shortest = std::min(shortest, naive::length(mesh_.points[neighbour] - mesh_.points[vertex]));
    return shortest;
  }

  const naive::Mesh& mesh_;
  naive::Rings rings_;
  naive::Ring ring_;
  std::vector<double> border_weights_;
  double unit_ = 0;
};

}  // namespace plait::test
