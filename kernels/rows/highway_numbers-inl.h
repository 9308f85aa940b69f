// Numbers (plait/detail/numbers.h) in a register of one instruction set. This header is included
// once for each instruction set. Each lane has the same IEEE operations in the same order, and no
// operation is fused, so every lane has the same bits as a single number. The operations are
// explicit, because compilers turn loops over lanes into scalar code on some instruction sets.
// Pinned by tests/kernels/fused_rows_test.cpp and fused_butterfly_rows_test.cpp on every
// instruction set, and rows_assembly_test.sh.
// Functions that take these numbers are not compiled for an instruction set themselves. So they
// must be inlined ([[gnu::always_inline]]) into a function that is.
#if defined(PLAIT_KERNELS_ROWS_HIGHWAY_NUMBERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_ROWS_HIGHWAY_NUMBERS_INL_H
#undef PLAIT_KERNELS_ROWS_HIGHWAY_NUMBERS_INL_H
#else
#define PLAIT_KERNELS_ROWS_HIGHWAY_NUMBERS_INL_H
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "plait/extend/fused.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// D is a tag of Highway. (All functions have HWY_ATTR, because a friend function of a template
/// does not get the instruction set of the code around it.)
template <class D>
struct HighwayNumbers {
  using Real = hn::TFromD<D>;
  static constexpr int kCount = static_cast<int>(hn::MaxLanes(D()));

  hn::Vec<D> v;

  static HWY_ATTR inline HighwayNumbers load(const Real* from) { return {hn::Load(D(), from)}; }
  static HWY_ATTR inline HighwayNumbers zero() { return {hn::Zero(D())}; }
  HWY_ATTR inline void store(Real* to) const { hn::Store(v, D(), to); }

  friend HWY_ATTR inline HighwayNumbers operator+(const HighwayNumbers& a,
                                                  const HighwayNumbers& b) {
    return {hn::Add(a.v, b.v)};
  }
  friend HWY_ATTR inline HighwayNumbers operator-(const HighwayNumbers& a,
                                                  const HighwayNumbers& b) {
    return {hn::Sub(a.v, b.v)};
  }
  friend HWY_ATTR inline HighwayNumbers operator*(const HighwayNumbers& a,
                                                  const HighwayNumbers& b) {
    return {hn::Mul(a.v, b.v)};
  }
  friend HWY_ATTR inline HighwayNumbers operator*(double factor, const HighwayNumbers& a) {
    return {hn::Mul(hn::Set(D(), static_cast<Real>(factor)), a.v)};
  }
  friend HWY_ATTR inline HighwayNumbers operator/(const HighwayNumbers& a, double divisor) {
    return {hn::Div(a.v, hn::Set(D(), static_cast<Real>(divisor)))};
  }

  /// One instruction each. For ring_sum() it makes no difference which of two zeros is the result,
  /// or whether a NaN is the result of one function or of both. But a NaN must not get lost, and
  /// Highway's own scalar minimum would lose it.
  friend HWY_ATTR inline HighwayNumbers smaller(const HighwayNumbers& a, const HighwayNumbers& b) {
#if HWY_TARGET == HWY_SCALAR
    return {hn::IfThenElse(hn::Lt(b.v, a.v), b.v, a.v)};
#else
    return {hn::Min(b.v, a.v)};
#endif
  }
  friend HWY_ATTR inline HighwayNumbers larger(const HighwayNumbers& a, const HighwayNumbers& b) {
#if HWY_TARGET == HWY_SCALAR
    return {hn::IfThenElse(hn::Lt(b.v, a.v), a.v, b.v)};
#else
    return {hn::Max(a.v, b.v)};
#endif
  }
};

/// As many numbers as a register holds, all of one axis of a point.
template <class Real>
using LaneTag = hn::CappedTag<Real, kPatchLanes>;
template <class Real>
using LaneNumbers = HighwayNumbers<LaneTag<Real>>;
using WideNumbers = LaneNumbers<double>;
/// As many numbers of `Real` as there are WideNumbers.
template <class Real>
using NarrowNumbers = HighwayNumbers<hn::Rebind<Real, LaneTag<double>>>;

template <class D>
HWY_ATTR inline WideNumbers widened(const HighwayNumbers<D>& a) {
  if constexpr (std::is_same_v<D, LaneTag<double>>)
    return a;
  else
    return {hn::PromoteTo(LaneTag<double>(), a.v)};
}
template <class Real>
HWY_ATTR inline NarrowNumbers<Real> narrowed(const WideNumbers& a) {
  constexpr hn::Rebind<Real, LaneTag<double>> narrow;
  if constexpr (std::is_same_v<Real, double>)
    return a;
  else
#if HWY_TARGET == HWY_SCALAR
    // Highway's own conversion would turn numbers that are too large into the largest float.
    return {hn::Set(narrow, static_cast<Real>(hn::GetLane(a.v)))};
#else
    return {hn::DemoteTo(narrow, a.v)};
#endif
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
