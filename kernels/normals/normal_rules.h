// Computes unit normals of a Loop surface by its tangent masks.
//
// Interior: t1 = sum cos(2 pi i/n) p_i, t2 = sum sin(2 pi i/n) p_i (C. Loop 1987; H. Hoppe et al.,
// "Piecewise Smooth Surface Reconstruction", 1994). For n = 6 these are combinations of the
// differences of opposite neighbours, so rotating the ring by 180 degrees does not change any bit.
//
// Border, neighbours p_1 .. p_k counterclockwise from border to border: along it p_1 - p_k; across
// it the left eigenvector of the plain border rules (odd 1/2 1/2, even 1/8 3/4 1/8) to the
// eigenvalue lambda = 3/8 + cos(theta)/4, theta = pi/(k-1):
//   y_i = sin((i-1) theta) at p_2 .. p_(k-1), a at p_1 and p_k, c at v, where
//   a (lambda - 1/2) = (y_2 + c)/8 and c (lambda - 3/4) = 3/8 sum(y) + a.
// For k = 4 that is Hoppe's (-2, -1, 2, 2, -1); for k = 2 the eigenvalue is 1/4 and the mask
// p_1 + p_2 - 2 v. Pinned by tests/kernels/normals_test.cpp.
// All sums add differences to v, or between neighbours. So in float32 only the rounding of the
// positions limits the accuracy of the angle: a few units in the last place of a coordinate,
// divided by the length of the local edges.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "base/regular_normal.h"
#include "plait/detail/numbers.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

namespace plait::normals {

// The rules of vertices that are no base vertices are in base/regular_normal.h. This one is not
// inlined: rows call it for single lanes only, and their loops stay short.
template <class Real>
[[gnu::noinline]] Vector3<float> regular(Vector3<Real> d0, Vector3<Real> d1, Vector3<Real> d2) {
  return RegularNormal::interior(d0, d1, d2);
}

/// The weights of the mask across a border, for `neighbours` >= 3 neighbours.
struct BorderMask {
  double theta, end_weight;
};
inline BorderMask border_mask(int neighbours) {
  const double theta = std::numbers::pi / (neighbours - 1);
  const double lambda = 0.375 + 0.25 * std::cos(theta);
  const double sum = 1 / std::tan(theta / 2), second = std::sin(theta);
  // This follows from c = 8 a (lambda - 1/2) - y_2 and the second equation.
  const double end_weight =
      (0.375 * sum + second * (lambda - 0.75)) / (8 * (lambda - 0.5) * (lambda - 0.75) - 1);
  return {theta, end_weight};
}

/// The two tangent masks of base vertices. The sine and cosine for each neighbour take more time
/// than the rest of the work on a base vertex, so they are computed once for each valence. Only one
/// thread at a time may use an object.
class BaseMasks {
 public:
  struct Weights {
    double first, second;
  };
  /// The weights: [neighbour]. Valid until the next call.
  std::span<const Weights> of(int valence, bool border) {
    // Masks of higher valences are not stored: such vertices are rare and their masks are large.
    std::vector<Weights>& mask =
        static_cast<std::size_t>(valence) <= kMostKept
            ? kept_[2 * static_cast<std::size_t>(valence) + (border ? 1 : 0)]
            : last_large_;
    if (mask.empty() || &mask == &last_large_) {
      mask.clear();
      fill(valence, border, mask);
    }
    return mask;
  }

 private:
  static constexpr std::size_t kMostKept = 64;

  static void fill(int valence, bool border, std::vector<Weights>& mask) {
    const BorderMask at_border = border && valence > 2 ? border_mask(valence) : BorderMask{0, 1};
    for (int i = 0; i < valence; ++i) {
      const double angle = 2 * std::numbers::pi * i / valence;
      const bool at_first = i == 0, at_last = i == valence - 1;
      if (!border)
        mask.push_back({std::cos(angle), std::sin(angle)});
      else if (at_first || at_last)
        mask.push_back({at_first ? 1.0 : -1.0, at_border.end_weight});
      else
        mask.push_back({0, std::sin(i * at_border.theta)});
    }
  }

  std::array<std::vector<Weights>, 2 * (kMostKept + 1)> kept_;  ///< [2 valence + border]
  std::vector<Weights> last_large_;
};

/// The normal of a base vertex from its ring. point(i) are its neighbours, counterclockwise, as
/// many as the mask has weights.
template <class Point>
Vector3<float> of_base_vertex(std::span<const BaseMasks::Weights> mask, const Vector3<double>& v,
                              Point point) {
  Vector3<double> first{}, second{};
  int i = 0;
  for (const auto& [along, across] : mask) {
    const Vector3<double> d = point(i++) - v;
    first = first + along * d;
    second = second + across * d;
  }
  return RegularNormal::direction_of_cross(first, second);
}

/// Computes the normals of the base vertices. `rings` has their neighbours at the finest level.
template <class Real>
void base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
          std::span<const Vector3<Real>> positions, std::span<Vector3<float>> normals) {
  BaseMasks masks;
  std::vector<Vector3<double>> ring;
  for (VertexId vertex = 0; vertex < positions.size(); ++vertex) {
    ring.clear();
    for_each_spoke(mesh, vertex,
                   [&](EdgeId edge) { ring.push_back(widen(rings.next_to(mesh, edge, vertex))); });
    normals[vertex] = of_base_vertex(
        masks.of(static_cast<int>(ring.size()), is_border_vertex(mesh, vertex)),
        widen(positions[vertex]), [&](int i) { return ring[static_cast<std::size_t>(i)]; });
  }
}

}  // namespace plait::normals
