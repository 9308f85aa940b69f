// The rows of one-ring rules (plait/detail/rule_rows.h) as functions for one instruction set.
// Included once for each instruction set.
#if defined(PLAIT_KERNELS_ROWS_ONE_RING_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_ROWS_ONE_RING_ROWS_INL_H
#undef PLAIT_KERNELS_ROWS_ONE_RING_ROWS_INL_H
#else
#define PLAIT_KERNELS_ROWS_ONE_RING_ROWS_INL_H
#endif

#include "plait/detail/one_ring.h"
#include "plait/detail/rule_rows.h"
#include "rows/highway_numbers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

template <class Rule, class Real>
void odd_row(const void* rule, const OddRow<Real>& row) {
  rule_rows::odd_row<LaneNumbers<Real>>(*static_cast<const Rule*>(rule), row);
}
template <class Rule, class Real>
void even_row(const void* rule, const EvenRow<Real>& row) {
  rule_rows::even_row<LaneNumbers<Real>>(*static_cast<const Rule*>(rule), row);
}
template <class Rule, class Real>
void limit_row(const void* rule, const SurfaceRow<Real, Real>& row) {
  rule_rows::limit_row<LaneNumbers<Real>>(*static_cast<const Rule*>(rule), row);
}
template <class Rule, class Real>
void ring_step(const void* rule, const RingStep<Real>& step) {
  rule_rows::ring_step<NarrowNumbers<Real>, WideNumbers>(*static_cast<const Rule*>(rule), step);
}

/// Sets the row functions of `functions` to these.
template <class Rule, class Real>
void put_rows(OneRingFunctions<Real>& functions) {
  functions.odd_row = odd_row<Rule, Real>;
  functions.even_row = even_row<Rule, Real>;
  if constexpr (kHasLimits<Rule>) functions.limit_row = limit_row<Rule, Real>;
  functions.ring_step = ring_step<Rule, Real>;
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
