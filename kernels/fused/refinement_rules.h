// What a refinement rule with a one-ring says to the fused executor: the same expressions that the
// other executors evaluate.
#pragma once

#include "loop/loop_expressions.h"
#include "midpoint/midpoint_diamond.h"

namespace plait::fused_rows {

struct LoopRule {
  static constexpr bool kMovesEven = true;
  template <class Real>
  static constexpr Real odd(Real a, Real b, Real c, Real d) {
    return loop::odd(a, b, c, d);
  }
  template <class Real>
  static constexpr Real odd_border(Real a, Real b) {
    return Real(0.5) * (a + b);
  }
  template <class Real>
  static constexpr Real even(Real v, Real pair0, Real pair1, Real pair2) {
    return loop::even(v, pair0, pair1, pair2);
  }
  template <class Real>
  static constexpr Real even_border(Real v, Real neighbour0, Real neighbour1) {
    return loop::even_border(v, neighbour0, neighbour1);
  }
  /// Weight of one new neighbour of a base vertex of this valence.
  static double base_weight(int valence) { return loop::odd_neighbour_weight(valence); }
};

/// Even vertices stay where they are.
struct MidpointRule {
  static constexpr bool kMovesEven = false;
  template <class Real>
  static constexpr Real odd(Real a, Real b, Real, Real) {
    return midpoint::odd(a, b);
  }
  template <class Real>
  static constexpr Real odd_border(Real a, Real b) {
    return midpoint::odd(a, b);
  }
};

}  // namespace plait::fused_rows
