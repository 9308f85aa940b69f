// The built-in rules, for the instruction set that is chosen at the time of the call.
#pragma once

#include "fused/patch_rows.h"

namespace plait {

template <class Real>
fused_rows::OneRingRows<Real> loop_rows();
template <class Real>
fused_rows::OneRingRows<Real> midpoint_rows();
template <class Real>
fused_rows::ButterflyRows<Real> butterfly_rows();

}  // namespace plait
