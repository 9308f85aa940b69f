// The library's rows, for the best instruction set of the processor (or the one that a test or a
// measurement chooses) at the time of the call.
#pragma once

#include "plait/kernels/one_ring.h"
#include "plait/kernels/rows.h"
#include "rows/butterfly_rows.h"

namespace plait {

/// Puts the rows of one of the library's rules into `functions`.
template <class Rule, class Real>
void choose_rows(OneRingFunctions<Real>& functions);

template <class Real>
ButterflyRows<Real> butterfly_rows();

/// Unit normals, the same for every scheme.
template <class Real>
using NormalRow = void (*)(const SurfaceRow<Real, float>&);
template <class Real>
NormalRow<Real> normal_row();

}  // namespace plait
