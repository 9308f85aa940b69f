// The modified Butterfly scheme, which is interpolating and reads two rings around a vertex.
// kernels/butterfly/ has the stencils and their sources.
#pragma once

#include "plait/detail/scheme.h"
#include "rows/dispatched_rows.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Has the role of OneRing for this scheme.
template <class RealType>
struct Butterfly {
  using Real = RealType;
  static constexpr int kRingCount = 2;

  ButterflyRows<Real> rows = butterfly_rows<Real>();

  void ring_step(const RingStep<Real>& step) const { rows.ring_step(step); }
};

struct ButterflyScheme {
  static constexpr LibraryScheme kScheme = LibraryScheme::kButterfly;
  static constexpr SchemeTraits kTraits{.name = "butterfly", .ring_count = 2};
  template <class Real>
  static Butterfly<Real> rule() {
    return {};
  }
};

PLAIT_END_NAMESPACE
