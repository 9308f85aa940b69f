// The library's row functions. Each call uses the best instruction set of the processor, or the one
// that a test or a measurement has chosen.
#pragma once

#include "plait/detail/one_ring.h"
#include "plait/detail/rows.h"
#include "rows/butterfly_rows.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Sets the row functions of `functions` to those of a library rule.
template <class Rule, class Real>
void choose_rows(OneRingFunctions<Real>& functions);

template <class Real>
ButterflyRows<Real> butterfly_rows();

/// The function that computes rows of unit normals, for every scheme.
template <class Real>
using NormalRow = void (*)(const SurfaceRow<Real, float>&);
template <class Real>
NormalRow<Real> normal_row();

PLAIT_END_NAMESPACE
