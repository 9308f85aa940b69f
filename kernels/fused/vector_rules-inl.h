// The rules of regular vertices in vectors: the same IEEE operations in the same order as their
// scalar twins (loop_rules.h, midpoint_diamond.h, butterfly/stencils.h, normals/normal_rules.h), so
// every lane has the twin's bits. Written out because compilers turn loops over lanes into scalar
// code on some instruction sets. Pinned by tests/kernels/fused_rows_test.cpp and
// fused_butterfly_rows_test.cpp on every instruction set. Included once for each.
#if defined(PLAIT_KERNELS_FUSED_VECTOR_RULES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_FUSED_VECTOR_RULES_INL_H
#undef PLAIT_KERNELS_FUSED_VECTOR_RULES_INL_H
#else
#define PLAIT_KERNELS_FUSED_VECTOR_RULES_INL_H
#endif

#include <hwy/highway.h>

#include "fused/refinement_rules.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// factor * v, in every lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V times(D d, double factor, V v) {
  return hn::Mul(hn::Set(d, static_cast<hn::TFromD<D>>(factor)), v);
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE V odd(LoopRule, D d, V a, V b, V c, V opposite) {
  return hn::Add(times(d, 0.375, hn::Add(a, b)), times(d, 0.125, hn::Add(c, opposite)));
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V odd(MidpointRule, D d, V a, V b, V, V) {
  return times(d, 0.5, hn::Add(a, b));
}

/// loop::smaller() and loop::larger(): one instruction each. Which of two zeros comes out, or
/// whether what is no number comes out once or twice, makes no difference to the sum below; that it
/// comes out at all does, and Highway's own scalar minimum would drop it.
#if HWY_TARGET == HWY_SCALAR
template <class V>
HWY_INLINE V smaller(V a, V b) {
  return hn::IfThenElse(hn::Lt(b, a), b, a);
}
template <class V>
HWY_INLINE V larger(V a, V b) {
  return hn::IfThenElse(hn::Lt(b, a), a, b);
}
#else
template <class V>
HWY_INLINE V smaller(V a, V b) {
  return hn::Min(b, a);
}
template <class V>
HWY_INLINE V larger(V a, V b) {
  return hn::Max(a, b);
}
#endif

/// loop::ring_sum().
template <class V>
HWY_INLINE V ring_sum(V pair0, V pair1, V pair2) {
  const V low = smaller(pair0, pair1), high = larger(pair0, pair1);
  const V middle = smaller(high, pair2);
  return hn::Add(hn::Add(smaller(low, middle), larger(low, middle)), larger(high, pair2));
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V even(LoopRule, D d, V v, V pair0, V pair1, V pair2) {
  return hn::Add(times(d, 0.4, v), times(d, 0.1, ring_sum(pair0, pair1, pair2)));
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE V limit(D d, V v, V pair0, V pair1, V pair2) {
  const V twelve = hn::Set(d, hn::TFromD<D>(12));
  return hn::Add(times(d, 0.5, v), hn::Div(ring_sum(pair0, pair1, pair2), twelve));
}

/// The three numbers of as many points as a vector has lanes.
template <class V>
struct Axes {
  V x, y, z;

  friend HWY_INLINE Axes operator+(const Axes& a, const Axes& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
  }
  friend HWY_INLINE Axes operator-(const Axes& a, const Axes& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
  }
  friend HWY_INLINE Axes operator*(V scale, const Axes& a) {
    return {hn::Mul(scale, a.x), hn::Mul(scale, a.y), hn::Mul(scale, a.z)};
  }
};

/// normals::regular_cross().
template <class D, class V = hn::Vec<D>>
HWY_INLINE Axes<V> regular_cross(D d, const Axes<V>& d0, const Axes<V>& d1, const Axes<V>& d2) {
  const Axes<V> a = d0 + hn::Set(d, hn::TFromD<D>(0.5)) * (d1 - d2), b = d1 + d2;
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
template <class V>
HWY_INLINE V square_of(const Axes<V>& a) {
  return hn::Add(hn::Add(hn::Mul(a.x, a.x), hn::Mul(a.y, a.y)), hn::Mul(a.z, a.z));
}
/// normals::comfortable() in every lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE bool all_comfortable(D d, V square) {
  using Real = hn::TFromD<D>;
  return hn::AllTrue(
      d, hn::And(hn::Gt(square, hn::Set(d, Real(1e-30))), hn::Lt(square, hn::Set(d, Real(1e30)))));
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
