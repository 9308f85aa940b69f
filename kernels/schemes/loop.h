// Loop subdivision in place: the expressions for every vertex.
//
// C. Loop, "Smooth Subdivision Surfaces Based on Triangles", master's thesis, University of Utah,
// 1987. The even rule in place, which reads the new odd neighbours, is from I. Guskov,
//       "Non-replicating indexing for out-of-core processing of semi-regular triangular surface
//       meshes", section 5. Limit masks: D. Zorin, P. Schroeder, "Subdivision for Modeling and
//       Animation",
// SIGGRAPH course notes, 2000. Pinned by tests/kernels/schemes_test.cpp against an independent
// oracle. The rules of the library are always inlined, so that they are compiled for the
// instruction set of their caller.
#pragma once

#include <cmath>
#include <numbers>

#include "plait/detail/one_ring.h"
#include "plait/detail/scheme.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct LoopRule {
  template <class V>
  [[gnu::always_inline]] V odd(const V& a, const V& b, const V& c, const V& d) const {
    return 0.375 * (a + b) + 0.125 * (c + d);
  }
  template <class V>
  [[gnu::always_inline]] V odd_border(const V& a, const V& b) const {
    return 0.5 * (a + b);
  }

  template <class V>
  [[gnu::always_inline]] V even(const V& v, const V& ring) const {
    return 0.4 * v + 0.1 * ring;
  }
  template <class V>
  [[gnu::always_inline]] V even_border(const V& v, const V& p, const V& q) const {
    return 0.5 * v + 0.25 * (p + q);
  }
  /// The weight b = 8/5 b' of one new odd neighbour in the in-place rule.
  double even_weight(int valence) const { return 1.6 * old_neighbour_weight(valence); }

  template <class V>
  [[gnu::always_inline]] V limit(const V& v, const V& ring) const {
    return 0.5 * v + ring / 12;
  }
  template <class V>
  [[gnu::always_inline]] V limit_border(const V& v, const V& p, const V& q) const {
    return (4 * v + (p + q)) / 6;
  }
  double limit_weight(int valence) const {
    return 1 / (valence + 0.375 / old_neighbour_weight(valence));
  }

 private:
  /// b' of Loop 1987: the weight of one old neighbour.
  static double old_neighbour_weight(int valence) {
    const double centre = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / valence);
    return (0.625 - centre * centre) / valence;
  }
};

struct LoopScheme {
  static constexpr LibraryScheme kScheme = LibraryScheme::kLoop;
  static constexpr SchemeTraits kTraits{
      .name = "loop", .ring_count = 1, .moves_even = true, .has_limits = true};
  template <class Real>
  static OneRing<Real> rule() {
    return loop_scheme().rule<Real>();
  }
};

PLAIT_END_NAMESPACE
