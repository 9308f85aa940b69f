// Bodies of PatchRows and OneRingRows: loops over the points of a row, a vector of lanes at a time.
// Included once for each instruction set.
#if defined(PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#undef PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#else
#define PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "fused/patch_rows.h"
#include "fused/refinement_rules.h"
#include "fused/vector_rules-inl.h"
#include "normals/normal_rules.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

/// As many numbers at once as a vector holds, all of one axis of a point.
template <class Real>
using LaneTag = hn::CappedTag<Real, kPatchLanes>;

template <class Rule, class Real>
void odd_row(const OddRow<Real>& row) {
  const LaneTag<Real> d;
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += hn::Lanes(d))
      hn::Store(odd(Rule{}, d, hn::Load(d, row.a + k), hn::Load(d, row.b + k),
                    hn::Load(d, row.c + k), hn::Load(d, row.d + k)),
                d, row.to + from + k);
  }
}

/// Sums of the pairs of opposite neighbours at number `at` of their rows.
template <class D, class Real>
HWY_INLINE auto pair_sum(D d, const Neighbours<Real>& neighbours, std::size_t pair,
                         std::size_t at) {
  const auto& [first, second] = neighbours.pairs[pair];
  return hn::Add(hn::Load(d, first + at), hn::Load(d, second + at));
}

template <class Rule, class Real>
void even_row(const EvenRow<Real>& row) {
  const LaneTag<Real> d;
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += hn::Lanes(d)) {
      auto v = hn::Load(d, row.v + k);
      if constexpr (Rule::kMovesEven)
        v = even(Rule{}, d, v, pair_sum(d, row.neighbours, 0, from + k),
                 pair_sum(d, row.neighbours, 1, from + k),
                 pair_sum(d, row.neighbours, 2, from + k));
      hn::Store(v, d, row.to + from + k);
    }
  }
}

template <class Real>
void limit_row(const SurfaceRow<Real, Real>& row) {
  const LaneTag<Real> d;
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t at = static_cast<std::size_t>(i * row.step) * kPointNumbers;
    for (std::size_t k = at; k < at + kPointNumbers; k += hn::Lanes(d))
      hn::Store(limit(d, hn::Load(d, row.v + k), pair_sum(d, row.neighbours, 0, k),
                      pair_sum(d, row.neighbours, 1, k), pair_sum(d, row.neighbours, 2, k)),
                d, row.to + k);
  }
}

/// The difference of a pair of opposite neighbours, at number `at` of their rows on.
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
/// In one lane, which is number `at`.
template <class Real>
Vector3<Real> difference(const Neighbours<Real>& neighbours, std::size_t pair, std::size_t at) {
  const Real *a = neighbours.pairs[pair][0] + at, *b = neighbours.pairs[pair][1] + at;
  constexpr std::size_t y = kPatchLanes, z = 2 * kPatchLanes;
  return {a[0] - b[0], a[y] - b[y], a[z] - b[z]};
}

/// Unit normals have components of float, negative zeros made positive.
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

template <class D, class V>
HWY_INLINE hn::Vec<D> promoted(D wide, V v) {
  if constexpr (std::is_same_v<V, hn::Vec<D>>)
    return v;
  else
    return hn::PromoteTo(wide, v);
}

template <class Rule, class Real>
void fan_step(const FanStep<Real>& step) {
  const auto n = static_cast<std::size_t>(step.valence);
  const Real* HWY_RESTRICT v = step.from;
  Real* HWY_RESTRICT to = step.to;
  const hn::CappedTag<double, kPatchLanes> wide;
  const hn::Rebind<Real, decltype(wide)> d;
  HWY_ALIGN double sum[kPointNumbers];
  for (std::size_t k = 0; k < kPointNumbers; k += hn::Lanes(d)) {
    const auto neighbour = [&](std::size_t i)
                               HWY_ATTR { return hn::Load(d, v + (1 + i) * kPointNumbers + k); };
    const auto centre = hn::Load(d, v + k);
    auto total = hn::Zero(wide);
    auto before = neighbour(n - 1), here = neighbour(0);
    for (std::size_t i = 0; i < n; ++i) {
      const auto after = neighbour(i + 1 == n ? 0 : i + 1);
      const auto made = step.border && (i == 0 || i + 1 == n)
                            ? times(d, 0.5, hn::Add(centre, here))
                            : odd(Rule{}, d, centre, here, before, after);
      hn::Store(made, d, to + (1 + i) * kPointNumbers + k);
      total = hn::Add(total, promoted(wide, made));
      before = here;
      here = after;
    }
    hn::Store(total, wide, sum + k);
  }
  if constexpr (!Rule::kMovesEven) {
    for (std::size_t k = 0; k < kPointNumbers; ++k) to[k] = v[k];
  } else if (step.border) {
    const Real *first = to + kPointNumbers, *last = to + n * kPointNumbers;
    for (std::size_t k = 0; k < kPointNumbers; ++k)
      to[k] = Real(Rule::even_border(double(v[k]), double(first[k]), double(last[k])));
  } else {
    const double weight = Rule::base_weight(step.valence), kept = 1 - step.valence * weight;
    for (std::size_t k = 0; k < kPointNumbers; ++k)
      to[k] = Real(kept * double(v[k]) + weight * sum[k]);
  }
}

template <class Rule, class Real>
Vector3<Real> border_point(const Vector3<Real>& v, const Vector3<Real>& a, const Vector3<Real>& b) {
  if constexpr (Rule::kMovesEven)
    return {Rule::even_border(v.x, a.x, b.x), Rule::even_border(v.y, a.y, b.y),
            Rule::even_border(v.z, a.z, b.z)};
  else
    return v;
}

template <class Rule, class Real>
OneRingRows<Real> one_ring_rows() {
  return {{limit_row<Real>, normal_row<Real>, fan_step<Rule, Real>},
          odd_row<Rule, Real>,
          even_row<Rule, Real>,
          border_point<Rule, Real>};
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
