// The functions that compute rows of the modified Butterfly scheme.
#pragma once

#include <cstdint>

#include "plait/detail/rows.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The points A, B, C, D as in OddRow, and the wings beyond the edges AC, DB, CB and AD.
template <class Real>
struct WingedRow {
  const Real *a, *b, *c, *d, *wing_ac, *wing_db, *wing_cb, *wing_ad;
  Real* to;
  std::int64_t count;
};

template <class Real>
struct ButterflyRows {
  void (*odd)(const WingedRow<Real>&);
  void (*even)(const EvenRow<Real>&);  ///< copies the points; reads no neighbours
  void (*ring_step)(const RingStep<Real>&);
};

PLAIT_END_NAMESPACE
