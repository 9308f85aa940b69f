// Loop subdivision in place: the one expression behind every vertex, one number at a time.
//
// C. Loop, "Smooth Subdivision Surfaces Based on Triangles", master's thesis, University of Utah,
// 1987; the in-place form of the even rule, from the new odd neighbours, is I. Guskov's,
// "Non-replicating indexing for out-of-core processing of semi-regular triangular surface meshes",
// section 5. Limit masks: D. Zorin, P. Schroeder, "Subdivision for Modeling and Animation",
// SIGGRAPH course notes, 2000. Pinned by tests/kernels/loop_test.cpp against an independent oracle.
//
// Each expression is symmetric in what it reads, or runs in an order that the base mesh defines, so
// its bits do not depend on who evaluates it: both faces of an edge see the same sums.
//
// Private, since these are inline: a program of somebody else's would compile them with flags of
// its own, contract them, and give its copy to the linker for ours. plait/kernels/loop_rules.h has
// the same rules as functions of the library.
#pragma once

#include <cmath>
#include <numbers>

#include "plait/vector3.h"

namespace plait::loop {

/// Odd vertex between A and B, opposite C and D.
template <class Real>
constexpr Real odd(Real a, Real b, Real c, Real d) {
  return Real(0.375) * (a + b) + Real(0.125) * (c + d);
}

/// The smaller and the larger one; of equals (zeros of either sign) each comes out once. Written so
/// that compilers take one instruction for each.
template <class Real>
constexpr Real smaller(Real a, Real b) {
  return b < a ? b : a;
}
template <class Real>
constexpr Real larger(Real a, Real b) {
  return b < a ? a : b;
}

/// Sum of a regular one-ring: opposite pairs first, then these by size.
template <class Real>
constexpr Real ring_sum(Real pair0, Real pair1, Real pair2) {
  const Real low = smaller(pair0, pair1), high = larger(pair0, pair1);
  const Real middle = smaller(high, pair2);
  return (smaller(low, middle) + larger(low, middle)) + larger(high, pair2);
}

/// Even vertex of valence 6 from its new odd neighbours, given as the sums of opposite pairs.
template <class Real>
constexpr Real even(Real v, Real pair0, Real pair1, Real pair2) {
  return Real(0.4) * v + Real(0.1) * ring_sum(pair0, pair1, pair2);
}

/// Even vertex on a border, from its two new neighbours along it.
template <class Real>
constexpr Real even_border(Real v, Real neighbour0, Real neighbour1) {
  return Real(0.5) * v + Real(0.25) * (neighbour0 + neighbour1);
}

/// Limit position of a vertex of valence 6, and of one on a border.
template <class Real>
constexpr Real limit(Real v, Real pair0, Real pair1, Real pair2) {
  return Real(0.5) * v + ring_sum(pair0, pair1, pair2) / Real(12);
}
template <class Real>
constexpr Real limit_border(Real v, Real neighbour0, Real neighbour1) {
  return (Real(4) * v + (neighbour0 + neighbour1)) / Real(6);
}

/// A rule of three numbers at once, axis by axis.
template <class Real, class Rule, class... Vectors>
[[gnu::always_inline]] constexpr Vector3<Real> by_axis(Rule rule, const Vector3<Real>& first,
                                                       const Vectors&... rest) {
  return {rule(first.x, rest.x...), rule(first.y, rest.y...), rule(first.z, rest.z...)};
}

/// b' of Loop 1987: weight of one old neighbour in the even rule of a vertex of this valence.
inline double neighbour_weight(int valence) {
  const double centre = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / valence);
  return (0.625 - centre * centre) / valence;
}

/// b = 8/5 b': weight of one new odd neighbour in the in-place rule.
inline double odd_neighbour_weight(int valence) { return 1.6 * neighbour_weight(valence); }

/// Weight of one neighbour in the limit position.
inline double limit_weight(int valence) {
  return 1 / (valence + 0.375 / neighbour_weight(valence));
}

}  // namespace plait::loop
