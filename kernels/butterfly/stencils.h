// butterfly/stencils.h: the rules of modified Butterfly.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "plait/detail/numbers.h"

namespace plait::butterfly {

/// A regular odd vertex between A and B; C and D lie opposite. The wings are beyond AC and DB, CB
/// and AD.
template <class V>
[[gnu::always_inline]] inline V odd(const V& a, const V& b, const V& c, const V& d,
                                    const V& wing_ac, const V& wing_db, const V& wing_cb,
                                    const V& wing_ad) {
  return 0.5 * (a + b) + 0.125 * (c + d) - 0.0625 * ((wing_ac + wing_db) + (wing_cb + wing_ad));
}

/// An odd vertex on a border, by the four-point rule along the border.
template <class V>
[[gnu::always_inline]] inline V odd_border(const V& before, const V& a, const V& b,
                                           const V& after) {
  return 0.5625 * (a + b) - 0.0625 * (before + after);
}

/// The same for points.
template <class Real>
Vector3<Real> odd(const Vector3<Real>& a, const Vector3<Real>& b, const Vector3<Real>& c,
                  const Vector3<Real>& d, const Vector3<Real>& wing_ac,
                  const Vector3<Real>& wing_db, const Vector3<Real>& wing_cb,
                  const Vector3<Real>& wing_ad) {
  return by_axis([](const auto&... v) { return odd(v...); }, a, b, c, d, wing_ac, wing_db, wing_cb,
                 wing_ad);
}
template <class Real>
Vector3<Real> odd_border(const Vector3<Real>& before, const Vector3<Real>& a,
                         const Vector3<Real>& b, const Vector3<Real>& after) {
  return by_axis([](const auto&... v) { return odd_border(v...); }, before, a, b, after);
}

/// The wing beyond a border edge: the sum of its ends minus the third corner of the inner triangle.
template <class Point>
constexpr Point continued(const Point& end0, const Point& end1, const Point& inside) {
  return end0 + end1 - inside;
}

// The modified Butterfly rule at an extraordinary vertex, for all spokes of the vertex at once.
//
// D. Zorin, P. Schroeder, W. Sweldens, "Interpolating Subdivision for Meshes with Arbitrary
// Topology", SIGGRAPH 1996: 3/4 v + sum s_j e_j over the ring, j = 0 being the spoke itself,
// s_j = (1/n)(1/4 + cos(2 pi j/n) + 1/2 cos(4 pi j/n)) for n >= 5. These weights have only three
// frequencies. So three sums over the ring (a plain one, and two with sine and cosine) give the
// value on every spoke. The time for a vertex of valence n is proportional to n, not to n^2.
// Pinned by tests/kernels/schemes_test.cpp.

/// Calls set(k, new vertex next to v on spoke k) for each of the `valence` spokes. point(k) is the
/// old vertex on spoke k. Point is a type in double that has sums, and products with a number.
template <class Point, class Ring, class Set>
void for_each_spoke_value(int valence, const Point& v, Ring point, Set set) {
  const Point kept = 0.75 * v;
  if (valence < 5) {
    // There is no published rule for valence 2. These are the weights of valence 4, with those of
    // opposite spokes added.
    constexpr std::array<std::array<double, 4>, 3> kWeights = {{{3.0 / 8, -1.0 / 8, 0, 0},
                                                                {5.0 / 12, -1.0 / 12, -1.0 / 12, 0},
                                                                {3.0 / 8, 0, -1.0 / 8, 0}}};
    const auto& weights = kWeights[static_cast<std::size_t>(valence - 2)];
    for (int k = 0; k < valence; ++k) {
      Point sum{};
      for (int j = 0; j < valence; ++j)
        sum = sum + weights[static_cast<std::size_t>(j)] * point((k + j) % valence);
      set(k, kept + sum);
    }
    return;
  }
  const double step = 2 * std::numbers::pi / valence;
  Point plain{}, cosine1{}, sine1{}, cosine2{}, sine2{};
  for (int j = 0; j < valence; ++j) {
    const double angle = step * j;
    const Point p = point(j);
    plain = plain + p;
    cosine1 = cosine1 + std::cos(angle) * p;
    sine1 = sine1 + std::sin(angle) * p;
    cosine2 = cosine2 + std::cos(2 * angle) * p;
    sine2 = sine2 + std::sin(2 * angle) * p;
  }
  for (int k = 0; k < valence; ++k) {
    const double angle = step * k;
    set(k, kept + (1.0 / valence) *
                      (0.25 * plain + (std::cos(angle) * cosine1 + std::sin(angle) * sine1) +
                       0.5 * (std::cos(2 * angle) * cosine2 + std::sin(2 * angle) * sine2)));
  }
}

}  // namespace plait::butterfly
