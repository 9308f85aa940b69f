// Computes rows of the modified Butterfly scheme, one register of lanes at a time. Included once
// for each instruction set.
#if defined(PLAIT_KERNELS_ROWS_BUTTERFLY_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_ROWS_BUTTERFLY_ROWS_INL_H
#undef PLAIT_KERNELS_ROWS_BUTTERFLY_ROWS_INL_H
#else
#define PLAIT_KERNELS_ROWS_BUTTERFLY_ROWS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include "butterfly/rings.h"
#include "butterfly/stencils.h"
#include "fused/patch_lattice.h"
#include "plait/detail/rule_rows.h"
#include "rows/butterfly_rows.h"
#include "rows/highway_numbers-inl.h"
#include "schemes/midpoint.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

template <class Real>
void winged_row(const WingedRow<Real>& row) {
  using V = LaneNumbers<Real>;
  for (std::int64_t i = 0; i < row.count; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * kPointNumbers;
    for (std::size_t k = from; k < from + kPointNumbers; k += V::kCount)
      butterfly::odd(V::load(row.a + k), V::load(row.b + k), V::load(row.c + k), V::load(row.d + k),
                     V::load(row.wing_ac + k), V::load(row.wing_db + k), V::load(row.wing_cb + k),
                     V::load(row.wing_ad + k))
          .store(row.to + from + k);
  }
}
template <class Real>
void kept_row(const EvenRow<Real>& row) {
  rule_rows::even_row<LaneNumbers<Real>>(MidpointRule{}, row);
}

/// One point in each lane, in double, with the arithmetic that the rule of spokes needs.
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
void butterfly_ring_step(const RingStep<Real>& step) {
  using enum RingPart;
  using V = LaneNumbers<Real>;
  const RingShape shape{step.valence, step.border, 2};
  const auto from = [&](RingPart part, int spoke) {
    return step.from + shape.point(part, spoke) * kPointNumbers;
  };
  const auto to = [&](RingPart part, int spoke) {
    return step.to + shape.point(part, spoke) * kPointNumbers;
  };
  const Real* const v = step.from;
  const int last = step.valence - 1;
  const auto copy = [](const Real* point, Real* result) {
    for (std::size_t k = 0; k < kPointNumbers; ++k) result[k] = point[k];
  };
  const auto make_odd = [](const Real* a, const Real* b, const Real* c, const Real* d,
                           const Real* wing_ac, const Real* wing_db, const Real* wing_cb,
                           const Real* wing_ad, Real* result) HWY_ATTR {
    for (std::size_t k = 0; k < kPointNumbers; k += V::kCount)
      butterfly::odd(V::load(a + k), V::load(b + k), V::load(c + k), V::load(d + k),
                     V::load(wing_ac + k), V::load(wing_db + k), V::load(wing_cb + k),
                     V::load(wing_ad + k))
          .store(result + k);
  };
  copy(v, step.to);
  for (int i = 0; i <= last; ++i) {
    const Real *here = from(kNear, i), *before = from(kNear, i - 1), *after = from(kNear, i + 1);
    copy(here, to(kFar, i));
    if (step.border && (i == 0 || i == last)) {
      const Real *opposite = from(kNear, last - i), *far = from(kFar, i);
      Real* const result = to(kNear, i);
      for (std::size_t k = 0; k < kPointNumbers; k += V::kCount)
        butterfly::odd_border(V::load(opposite + k), V::load(v + k), V::load(here + k),
                              V::load(far + k))
            .store(result + k);
    } else if (step.border || step.valence == 6) {
      make_odd(v, here, after, before, from(kNear, i + 2), from(kBetween, i - 1), from(kBetween, i),
               from(kNear, i - 2), to(kNear, i));
    }
    if (step.border && i == last) continue;
    make_odd(here, after, v, from(kBetween, i), before, from(kFar, i + 1), from(kNear, i + 2),
             from(kFar, i), to(kBetween, i));
  }
  if (step.border) return butterfly::continue_ring(step.valence, step.to);
  if (step.valence == 6) return;
  const auto wide = [](const Real* point) {
    WidePoint result;
    for (std::size_t k = 0; k < kPointNumbers; ++k) result.k[k] = double(point[k]);
    return result;
  };
  butterfly::for_each_spoke_value(
      step.valence, wide(v), [&](int spoke) { return wide(from(kNear, spoke)); },
      [&](int spoke, const WidePoint& value) {
        Real* const result = to(kNear, spoke);
        for (std::size_t k = 0; k < kPointNumbers; ++k) result[k] = static_cast<Real>(value.k[k]);
      });
}

template <class Real>
ButterflyRows<Real> butterfly_rows() {
  return {winged_row<Real>, kept_row<Real>, butterfly_ring_step<Real>};
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
