// Rows of the modified Butterfly scheme.
#pragma once

#include <cstdint>

#include "plait/kernels/rows.h"

namespace plait {

/// Points A, B, C, D as in OddRow and the wings: over the edges AC, DB, CB and AD.
template <class Real>
struct WingedRow {
  const Real *a, *b, *c, *d, *wing_ac, *wing_db, *wing_cb, *wing_ad;
  Real* to;
  std::int64_t count;
};

template <class Real>
struct ButterflyRows {
  void (*odd)(const WingedRow<Real>&);
  void (*even)(const EvenRow<Real>&);  ///< copies; looks at no neighbours
  void (*ring_step)(const RingStep<Real>&);
};

}  // namespace plait
