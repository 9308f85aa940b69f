// The modified Butterfly scheme's stencils.
//
// D. Zorin, P. Schroeder, W. Sweldens, "Interpolating Subdivision for Meshes with Arbitrary
// Topology", SIGGRAPH 1996. The eight-point stencil is by N. Dyn, D. Levin and J. Gregory (1990),
// with tension 0. Ends on a border count as regular. A wing beyond a border, which does not exist,
// is replaced by the continuation of the inner triangle. Pinned by tests/kernels/schemes_test.cpp.
#pragma once

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

}  // namespace plait::butterfly
