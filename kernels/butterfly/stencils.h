// The modified Butterfly scheme's stencils, number by number.
//
// D. Zorin, P. Schroeder, W. Sweldens, "Interpolating Subdivision for Meshes with Arbitrary
// Topology", SIGGRAPH 1996; the eight-point stencil is N. Dyn's, D. Levin's and J. Gregory's (1990)
// with tension 0. Ends on a border count as regular, a wing missing beyond a border is the
// continuation of the triangle inside. Pinned by tests/kernels/schemes_test.cpp.
#pragma once

namespace plait::butterfly {

/// Regular odd vertex between A and B, opposite C and D; wings over AC and DB, over CB and AD.
template <class Real>
constexpr Real odd(Real a, Real b, Real c, Real d, Real wing_ac, Real wing_db, Real wing_cb,
                   Real wing_ad) {
  return Real(0.5) * (a + b) + Real(0.125) * (c + d) -
         Real(0.0625) * ((wing_ac + wing_db) + (wing_cb + wing_ad));
}

/// Odd vertex on a border: the four-point rule along it.
template <class Real>
constexpr Real odd_border(Real before, Real a, Real b, Real after) {
  return Real(0.5625) * (a + b) - Real(0.0625) * (before + after);
}

/// The wing over a border edge: its ends less the third corner of the triangle inside.
template <class Point>
constexpr Point continued(const Point& end0, const Point& end1, const Point& inside) {
  return end0 + end1 - inside;
}

}  // namespace plait::butterfly
