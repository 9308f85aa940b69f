// The modified Butterfly scheme: interpolating, and it reads two rings around a vertex. Its
// stencils and their sources: kernels/butterfly/.
#pragma once

#include "plait/kernels/scheme.h"
#include "rows/dispatched_rows.h"

namespace plait {

/// The counterpart of OneRing.
template <class RealType>
struct Butterfly {
  using Real = RealType;
  static constexpr int kReach = 2;

  ButterflyRows<Real> rows = butterfly_rows<Real>();

  void ring_step(const RingStep<Real>& step) const { rows.ring_step(step); }
};

struct ButterflyScheme {
  static constexpr Scheme kScheme = Scheme::kButterfly;
  static constexpr SchemeTraits kTraits{.name = "butterfly", .reach = 2};
  template <class Real>
  static Butterfly<Real> rule() {
    return {};
  }
};

}  // namespace plait
