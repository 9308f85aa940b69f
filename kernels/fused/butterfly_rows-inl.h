// Bodies of ButterflyRows, after the manner of patch_rows-inl.h. Included once for each instruction
// set.
#if defined(PLAIT_KERNELS_FUSED_BUTTERFLY_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_FUSED_BUTTERFLY_ROWS_INL_H
#undef PLAIT_KERNELS_FUSED_BUTTERFLY_ROWS_INL_H
#else
#define PLAIT_KERNELS_FUSED_BUTTERFLY_ROWS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include "butterfly/spoke_rule.h"
#include "butterfly/stencils.h"
#include "fused/fan_border.h"
#include "fused/fan_shape.h"
#include "fused/patch_rows-inl.h"
#include "fused/patch_rows.h"
#include "fused/refinement_rules.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

template <class Real>
void winged_row(const WingedRow<Real>& row) {
  const LaneTag<Real> d;
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += hn::Lanes(d)) {
      const auto sum = [&](const Real* one, const Real* other) HWY_ATTR {
        return hn::Add(hn::Load(d, one + k), hn::Load(d, other + k));
      };
      // butterfly::odd()
      const auto inner =
          hn::Add(times(d, 0.5, sum(row.a, row.b)), times(d, 0.125, sum(row.c, row.d)));
      const auto wings = hn::Add(sum(row.wing_ac, row.wing_db), sum(row.wing_cb, row.wing_ad));
      hn::Store(hn::Sub(inner, times(d, 0.0625, wings)), d, row.to + from + k);
    }
  }
}

/// A point of every lane in double, with the arithmetic that the rule of a vertex's spokes needs.
struct WidePoint {
  std::array<double, kPointNumbers> k{};

  friend WidePoint operator+(const WidePoint& a, const WidePoint& b) {
    WidePoint sum;
    for (std::size_t i = 0; i < kPointNumbers; ++i) sum.k[i] = a.k[i] + b.k[i];
    return sum;
  }
  friend WidePoint operator*(double scale, const WidePoint& a) {
    WidePoint product;
    for (std::size_t i = 0; i < kPointNumbers; ++i) product.k[i] = scale * a.k[i];
    return product;
  }
};

template <class Real>
void butterfly_fan_step(const FanStep<Real>& step) {
  using enum FanRing;
  const FanShape shape{step.valence, step.border, 2};
  const auto from = [&](FanRing ring, int spoke) {
    return step.from + shape.point(ring, spoke) * kPointNumbers;
  };
  const auto to = [&](FanRing ring, int spoke) {
    return step.to + shape.point(ring, spoke) * kPointNumbers;
  };
  const auto each = [](Real* result, auto rule) {
    for (std::size_t k = 0; k < kPointNumbers; ++k) result[k] = rule(k);
  };
  const Real* const v = step.from;
  const int last = step.valence - 1;
  each(step.to, [&](std::size_t k) { return v[k]; });
  for (int i = 0; i <= last; ++i) {
    const Real *here = from(kNear, i), *before = from(kNear, i - 1), *after = from(kNear, i + 1);
    each(to(kFar, i), [&](std::size_t k) { return here[k]; });
    if (step.border && (i == 0 || i == last)) {
      const Real *opposite = from(kNear, last - i), *far = from(kFar, i);
      each(to(kNear, i), [&](std::size_t k) {
        return butterfly::odd_border(opposite[k], v[k], here[k], far[k]);
      });
    } else if (step.border || step.valence == 6) {
      const Real *before_that = from(kNear, i - 2), *after_that = from(kNear, i + 2),
                 *between_before = from(kBetween, i - 1), *between = from(kBetween, i);
      each(to(kNear, i), [&](std::size_t k) {
        return butterfly::odd(v[k], here[k], after[k], before[k], after_that[k], between_before[k],
                              between[k], before_that[k]);
      });
    }
    if (step.border && i == last) continue;
    const Real *between = from(kBetween, i), *far = from(kFar, i), *far_after = from(kFar, i + 1),
               *after_that = from(kNear, i + 2);
    each(to(kBetween, i), [&](std::size_t k) {
      return butterfly::odd(here[k], after[k], v[k], between[k], before[k], far_after[k],
                            after_that[k], far[k]);
    });
  }
  if (step.border) return butterfly::continue_fan(step.valence, step.to);
  if (step.valence == 6) return;
  const auto wide = [](const Real* point) {
    WidePoint result;
    for (std::size_t k = 0; k < kPointNumbers; ++k) result.k[k] = double(point[k]);
    return result;
  };
  butterfly::for_each_spoke_value(
      step.valence, wide(v), [&](int spoke) { return wide(from(kNear, spoke)); },
      [&](int spoke, const WidePoint& value) {
        each(to(kNear, spoke), [&](std::size_t k) { return static_cast<Real>(value.k[k]); });
      });
}

template <class Real>
ButterflyRows<Real> butterfly_rows() {
  return {{limit_row<Real>, normal_row<Real>, butterfly_fan_step<Real>},
          winged_row<Real>,
          even_row<MidpointRule, Real>};
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
