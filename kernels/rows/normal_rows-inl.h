// Computes normals of a row of points, one register of lanes at a time, with the same operations as
// the scalar functions in normals/normal_rules.h. Included once for each instruction set.
#if defined(PLAIT_KERNELS_ROWS_NORMAL_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_ROWS_NORMAL_ROWS_INL_H
#undef PLAIT_KERNELS_ROWS_NORMAL_ROWS_INL_H
#else
#define PLAIT_KERNELS_ROWS_NORMAL_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include "normals/normal_rules.h"
#include "plait/detail/rows.h"
#include "rows/highway_numbers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

/// The three numbers of several points, one point in each lane.
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

/// The product in RegularNormal::interior().
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
/// Whether RegularNormal::comfortable() is true in every lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE bool all_comfortable(D d, V square) {
  using Real = hn::TFromD<D>;
  return hn::AllTrue(
      d, hn::And(hn::Gt(square, hn::Set(d, Real(1e-30))), hn::Lt(square, hn::Set(d, Real(1e30)))));
}

/// The difference of a pair of opposite neighbours, from index `at` of their rows on.
template <class D, class Real>
HWY_INLINE Axes<hn::Vec<D>> pair_difference(D d, const Neighbours<Real>& neighbours,
                                            std::size_t pair, std::size_t at) {
  const auto axes = [&](const Real* x) HWY_ATTR {
    return Axes<hn::Vec<D>>{hn::Load(d, x), hn::Load(d, x + kPatchLanes),
                            hn::Load(d, x + 2 * kPatchLanes)};
  };
  const auto& [first, second] = neighbours.pairs[pair];
  return axes(first + at) - axes(second + at);
}
/// The same difference in one lane, at index `at`.
template <class Real>
Vector3<Real> difference(const Neighbours<Real>& neighbours, std::size_t pair, std::size_t at) {
  const Real *a = neighbours.pairs[pair][0] + at, *b = neighbours.pairs[pair][1] + at;
  constexpr std::size_t y = kPatchLanes, z = 2 * kPatchLanes;
  return {a[0] - b[0], a[y] - b[y], a[z] - b[z]};
}

/// Makes negative zeros positive.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void store_normal(D, V v, float* to) {
  const hn::Rebind<float, D> narrow;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(float))
    hn::Store(hn::Add(v, hn::Zero(narrow)), narrow, to);
  else
    hn::Store(hn::Add(hn::DemoteTo(narrow, v), hn::Zero(narrow)), narrow, to);
}

template <class Real>
void normal_row(const SurfaceRow<Real, float>& row) {
  const LaneTag<Real> d;
  const auto one = hn::Set(d, Real(1));
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t point = static_cast<std::size_t>(i * row.step) * kPointNumbers;
    for (std::size_t at = point; at < point + kPatchLanes; at += hn::Lanes(d)) {
      const auto towards = regular_cross(d, pair_difference(d, row.neighbours, 0, at),
                                         pair_difference(d, row.neighbours, 1, at),
                                         pair_difference(d, row.neighbours, 2, at));
      const auto square = square_of(towards);
      const auto normal = hn::Div(one, hn::Sqrt(square)) * towards;
      store_normal(d, normal.x, row.to + at);
      store_normal(d, normal.y, row.to + at + kPatchLanes);
      store_normal(d, normal.z, row.to + at + 2 * kPatchLanes);
      if (HWY_LIKELY(all_comfortable(d, square))) continue;
      for (std::size_t lane = at; lane < at + hn::Lanes(d); ++lane) {
        const Vector3<float> careful = normals::regular(difference(row.neighbours, 0, lane),
                                                        difference(row.neighbours, 1, lane),
                                                        difference(row.neighbours, 2, lane));
        row.to[lane] = careful.x;
        row.to[lane + kPatchLanes] = careful.y;
        row.to[lane + 2 * kPatchLanes] = careful.z;
      }
    }
  }
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
