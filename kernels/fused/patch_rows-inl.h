// Bodies of PatchRows and OneRingRows. Plain loops over lanes with the rules' own expressions:
// every instruction set evaluates the same ones. Included once for each.
#if defined(PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#undef PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#else
#define PLAIT_KERNELS_FUSED_PATCH_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <cmath>

#include "fused/patch_rows.h"
#include "fused/refinement_rules.h"
#include "normals/normal_rules.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

template <class Rule, class Real>
void odd_row(const OddRow<Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    const Real *HWY_RESTRICT a = row.a + from, *HWY_RESTRICT b = row.b + from,
                             *HWY_RESTRICT c = row.c + from, *HWY_RESTRICT d = row.d + from;
    Real* HWY_RESTRICT to = row.to + 2 * from;
    for (std::size_t k = 0; k < kPointNumbers; ++k) to[k] = Rule::odd(a[k], b[k], c[k], d[k]);
  }
}

template <class Rule, class Real>
void even_row(const EvenRow<Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t at = static_cast<std::size_t>(i) * kPointNumbers;
    const Real* HWY_RESTRICT v = row.v + at;
    Real* HWY_RESTRICT to = row.to + 2 * at;
    if constexpr (Rule::kMovesEven) {
      const auto& pairs = row.neighbours.pairs;
      const Real *HWY_RESTRICT a0 = pairs[0][0] + 2 * at, *HWY_RESTRICT b0 = pairs[0][1] + 2 * at,
                               *HWY_RESTRICT a1 = pairs[1][0] + 2 * at,
                               *HWY_RESTRICT b1 = pairs[1][1] + 2 * at,
                               *HWY_RESTRICT a2 = pairs[2][0] + 2 * at,
                               *HWY_RESTRICT b2 = pairs[2][1] + 2 * at;
      for (std::size_t k = 0; k < kPointNumbers; ++k)
        to[k] = Rule::even(v[k], a0[k] + b0[k], a1[k] + b1[k], a2[k] + b2[k]);
    } else {
      for (std::size_t k = 0; k < kPointNumbers; ++k) to[k] = v[k];
    }
  }
}

template <class Real>
void limit_row(const SurfaceRow<Real, Real>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t at = static_cast<std::size_t>(i * row.step) * kPointNumbers;
    const auto& pairs = row.neighbours.pairs;
    const Real *HWY_RESTRICT a0 = pairs[0][0] + at, *HWY_RESTRICT b0 = pairs[0][1] + at,
                             *HWY_RESTRICT a1 = pairs[1][0] + at,
                             *HWY_RESTRICT b1 = pairs[1][1] + at,
                             *HWY_RESTRICT a2 = pairs[2][0] + at,
                             *HWY_RESTRICT b2 = pairs[2][1] + at, *HWY_RESTRICT v = row.v + at;
    Real* HWY_RESTRICT to = row.to + at;
    for (std::size_t k = 0; k < kPointNumbers; ++k)
      to[k] = loop::limit(v[k], a0[k] + b0[k], a1[k] + b1[k], a2[k] + b2[k]);
  }
}

/// The difference of a pair in one lane.
template <class Real>
HWY_INLINE Vector3<Real> difference(const Real* a, const Real* b, std::size_t lane) {
  constexpr std::size_t y = kPatchLanes, z = 2 * kPatchLanes;
  return {a[lane] - b[lane], a[y + lane] - b[y + lane], a[z + lane] - b[z + lane]};
}

/// normals::comfortable() in every lane.
template <class Real>
HWY_INLINE bool all_comfortable(const Real* squares) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<Real, kPatchLanes> d;
  for (std::size_t lane = 0; lane < kPatchLanes; lane += hn::Lanes(d)) {
    const auto square = hn::Load(d, squares + lane);
    if (!hn::AllTrue(d, hn::And(hn::Gt(square, hn::Set(d, Real(1e-30))),
                                hn::Lt(square, hn::Set(d, Real(1e30))))))
      return false;
  }
  return true;
}

template <class Real>
void normal_row(const SurfaceRow<Real, float>& row) {
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t at = static_cast<std::size_t>(i * row.step) * kPointNumbers;
    const auto& pairs = row.neighbours.pairs;
    const Real *HWY_RESTRICT a0 = pairs[0][0] + at, *HWY_RESTRICT b0 = pairs[0][1] + at,
                             *HWY_RESTRICT a1 = pairs[1][0] + at,
                             *HWY_RESTRICT b1 = pairs[1][1] + at,
                             *HWY_RESTRICT a2 = pairs[2][0] + at,
                             *HWY_RESTRICT b2 = pairs[2][1] + at;
    float* HWY_RESTRICT to = row.to + at;
    // normals::regular() in all lanes at once: loops over arrays, which vectorise.
    HWY_ALIGN Real along[kPointNumbers], across[kPointNumbers], square[kPatchLanes];
    for (std::size_t k = 0; k < kPointNumbers; ++k) {
      const Real d0 = a0[k] - b0[k], d1 = a1[k] - b1[k], d2 = a2[k] - b2[k];
      along[k] = d0 + Real(0.5) * (d1 - d2);
      across[k] = d1 + d2;
    }
    HWY_ALIGN Real towards[kPointNumbers];
    constexpr std::size_t y = kPatchLanes, z = 2 * kPatchLanes;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const Real nx = along[y + lane] * across[z + lane] - along[z + lane] * across[y + lane];
      const Real ny = along[z + lane] * across[lane] - along[lane] * across[z + lane];
      const Real nz = along[lane] * across[y + lane] - along[y + lane] * across[lane];
      towards[lane] = nx;
      towards[y + lane] = ny;
      towards[z + lane] = nz;
      square[lane] = nx * nx + ny * ny + nz * nz;
    }
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const Real scale = Real(1) / std::sqrt(square[lane]);
      to[lane] = float(scale * towards[lane]) + 0.0f;
      to[y + lane] = float(scale * towards[y + lane]) + 0.0f;
      to[z + lane] = float(scale * towards[z + lane]) + 0.0f;
    }
    if (HWY_LIKELY(all_comfortable(square))) continue;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const Vector3<float> normal = normals::regular(
          difference(a0, b0, lane), difference(a1, b1, lane), difference(a2, b2, lane));
      to[lane] = normal.x;
      to[kPatchLanes + lane] = normal.y;
      to[2 * kPatchLanes + lane] = normal.z;
    }
  }
}

template <class Rule, class Real>
void fan_step(const FanStep<Real>& step) {
  const auto n = static_cast<std::size_t>(step.valence);
  const Real* HWY_RESTRICT v = step.from;
  Real* HWY_RESTRICT to = step.to;
  std::array<double, kPointNumbers> sum{};
  for (std::size_t i = 0; i < n; ++i) {
    const Real* p = v + (1 + i) * kPointNumbers;
    const Real* before = v + (i == 0 ? n : i) * kPointNumbers;
    const Real* after = v + (i + 1 == n ? 1 : i + 2) * kPointNumbers;
    Real* HWY_RESTRICT odd = to + (1 + i) * kPointNumbers;
    if (step.border && (i == 0 || i + 1 == n))
      for (std::size_t k = 0; k < kPointNumbers; ++k) odd[k] = Rule::odd_border(v[k], p[k]);
    else
      for (std::size_t k = 0; k < kPointNumbers; ++k)
        odd[k] = Rule::odd(v[k], p[k], before[k], after[k]);
    for (std::size_t k = 0; k < kPointNumbers; ++k) sum[k] += double(odd[k]);
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
