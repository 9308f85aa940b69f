// Linear subdivision: an odd vertex is the middle of its edge, and even vertices do not move.
// Pinned by tests/kernels/schemes_test.cpp.
#pragma once

#include "plait/detail/one_ring.h"
#include "plait/detail/scheme.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct MidpointRule {
  static constexpr bool kReadsEndsOnly = true;

  template <class V>
  [[gnu::always_inline]] V odd(const V& a, const V& b, const V&, const V&) const {
    return 0.5 * (a + b);
  }
  template <class V>
  [[gnu::always_inline]] V odd_border(const V& a, const V& b) const {
    return 0.5 * (a + b);
  }
};

struct MidpointScheme {
  static constexpr LibraryScheme kScheme = LibraryScheme::kMidpoint;
  static constexpr SchemeTraits kTraits{.name = "midpoint", .ring_count = 1};
  template <class Real>
  static OneRing<Real> rule() {
    return midpoint_scheme().rule<Real>();
  }
};

PLAIT_END_NAMESPACE
