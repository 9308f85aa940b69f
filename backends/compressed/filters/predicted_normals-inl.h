// The loops of slot_predictions.h for normals, with the operations of RegularNormal. Included once
// for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_NORMALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_NORMALS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_NORMALS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_NORMALS_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "base/regular_normal.h"
#include "compressed/filters/residual_vectors-inl.h"
#include "compressed/filters/slot_predictions.h"

HWY_BEFORE_NAMESPACE();
namespace plait::slot_predictions::HWY_NAMESPACE {

/// The points around one vertex: `v` is at the vertex, and `stride` leads to the next row.
template <class Real>
struct NormalPoints {
  const Real* v;
  std::int64_t stride;

  Vector3<Real> at(std::int64_t offset) const { return {v[offset], v[offset + 1], v[offset + 2]}; }
  Vector3<float> interior() const {
    return RegularNormal::interior(at(stride) - at(-stride), at(3) - at(-3),
                                   at(3 - stride) - at(stride - 3));
  }
  Vector3<float> border() const {
    return RegularNormal::border(at(0), at(3 - stride), at(-stride), at(-3), at(stride - 3));
  }
};

inline void store_normal(const Vector3<float>& normal, float* to) {
  to[0] = normal.x;
  to[1] = normal.y;
  to[2] = normal.z;
}

#if HWY_TARGET != HWY_SCALAR  // one lane cannot be interleaved

template <class V>
struct Axes {
  V x, y, z;
};

/// The differences of the points at `a` and of those at `b`, every second point, one in each lane.
template <class D, class Real = hn::TFromD<D>>
HWY_INLINE Axes<hn::Vec<D>> differences(D d, const Real* a, const Real* b) {
  HWY_ALIGN Real between[6 * hn::MaxLanes(D())];
  constexpr std::size_t kLanes = hn::MaxLanes(D());
  for (std::size_t i = 0; i < 6 * kLanes; i += kLanes)
    hn::Store(hn::Sub(hn::LoadU(d, a + i), hn::LoadU(d, b + i)), d, between + i);
  hn::Vec<D> x0, y0, z0, x1, y1, z1;
  hn::LoadInterleaved3(d, between, x0, y0, z0);
  hn::LoadInterleaved3(d, between + 3 * kLanes, x1, y1, z1);
  return {hn::ConcatEven(d, x1, x0), hn::ConcatEven(d, y1, y0), hn::ConcatEven(d, z1, z0)};
}

/// Adds +0, so that -0 becomes +0.
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<float, D>> narrowed(D, hn::Vec<D> v) {
  const hn::Rebind<float, D> narrow;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(float))
    return hn::Add(v, hn::Zero(narrow));
  else
    return hn::Add(hn::DemoteTo(narrow, v), hn::Zero(narrow));
}

/// As many normals as `d` has lanes.
template <class D, class Real = hn::TFromD<D>>
HWY_INLINE void normals_in_lanes(D d, NormalPoints<Real> points, float* to) {
  const Real* const v = points.v;
  const std::int64_t stride = points.stride;
  const auto d0 = differences(d, v + stride, v - stride), d1 = differences(d, v + 3, v - 3),
             d2 = differences(d, v + 3 - stride, v + stride - 3);
  const auto half = hn::Set(d, Real(0.5));
  const auto ax = hn::Add(d0.x, hn::Mul(half, hn::Sub(d1.x, d2.x))),
             ay = hn::Add(d0.y, hn::Mul(half, hn::Sub(d1.y, d2.y))),
             az = hn::Add(d0.z, hn::Mul(half, hn::Sub(d1.z, d2.z)));
  const auto bx = hn::Add(d1.x, d2.x), by = hn::Add(d1.y, d2.y), bz = hn::Add(d1.z, d2.z);
  const auto x = hn::Sub(hn::Mul(ay, bz), hn::Mul(az, by)),
             y = hn::Sub(hn::Mul(az, bx), hn::Mul(ax, bz)),
             z = hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
  const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
  // RegularNormal::comfortable()
  if (HWY_UNLIKELY(!hn::AllTrue(d, hn::And(hn::Gt(square, hn::Set(d, Real(1e-30))),
                                           hn::Lt(square, hn::Set(d, Real(1e30))))))) {
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane, points.v += 6, to += 3)
      store_normal(points.interior(), to);
    return;
  }
  const auto scale = hn::Div(hn::Set(d, Real(1)), hn::Sqrt(square));
  hn::StoreInterleaved3(narrowed(d, hn::Mul(scale, x)), narrowed(d, hn::Mul(scale, y)),
                        narrowed(d, hn::Mul(scale, z)), hn::Rebind<float, D>(), to);
}

/// The last vectors may overlap; few normals take shorter vectors, or none.
template <class D, class Real = hn::TFromD<D>>
HWY_INLINE void normal_row(D d, const NormalPoints<Real>& first, std::int64_t count, float* to) {
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  const auto some = [&](std::int64_t i) HWY_ATTR {
    normals_in_lanes(d, NormalPoints<Real>{first.v + 6 * i, first.stride}, to + 3 * i);
  };
  if (count >= lanes) {
    std::int64_t i = 0;
    for (; i + lanes <= count; i += lanes) some(i);
    if (i < count) some(count - lanes);
  } else if constexpr (hn::MaxLanes(D()) * sizeof(Real) > 16) {
    normal_row(hn::Half<D>(), first, count, to);
  } else {
    for (std::int64_t i = 0; i < count; ++i)
      store_normal(NormalPoints<Real>{first.v + 6 * i, first.stride}.interior(), to + 3 * i);
  }
}

#else

template <class D, class Real>
HWY_INLINE void normal_row(D, const NormalPoints<Real>& first, std::int64_t count, float* to) {
  for (std::int64_t i = 0; i < count; ++i)
    store_normal(NormalPoints<Real>{first.v + 6 * i, first.stride}.interior(), to + 3 * i);
}

#endif

template <class Real, class Finish>
HWY_INLINE void finish_normals(const NormalRows<Real>& rows, Finish finish) {
  const hn::ScalableTag<float> floats;
  for (std::int64_t row = 0; row < rows.side; ++row) {
    const std::int64_t records = rows.slot.records(rows.side, row);
    const std::int64_t inside = rows.slot.inside(rows.side, row);
    const NormalPoints<Real> first{rows.points + (2 * row + 1) * rows.stride + 3, rows.stride};
    normal_row(hn::ScalableTag<Real>(), first, inside, rows.predictions);
    if (rows.slot.border)
      store_normal(NormalPoints<Real>{first.v + 6 * inside, rows.stride}.border(),
                   rows.predictions + 3 * inside);
    in_vectors(floats, 0, 3 * records, [&](auto tag, std::int64_t i) HWY_ATTR {
      finish(tag, i, hn::LoadU(tag, rows.predictions + i));
    });
    finish = finish.advanced(3 * records);
  }
}

template <class Real>
HWY_INLINE void recode_slot(const NormalRows<Real>& rows, const std::uint32_t* from,
                            std::uint32_t* to, Recode recode) {
  recode == Recode::kEncode ? finish_normals(rows, Recoder<float, true>{from, to})
                            : finish_normals(rows, Recoder<float, false>{from, to});
}
inline void normals_from_floats(const NormalRows<float>& rows, const std::uint32_t* from,
                                std::uint32_t* to, Recode recode) {
  recode_slot(rows, from, to, recode);
}
inline void normals_from_doubles(const NormalRows<double>& rows, const std::uint32_t* from,
                                 std::uint32_t* to, Recode recode) {
  recode_slot(rows, from, to, recode);
}

}  // namespace plait::slot_predictions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_NORMALS_INL_H
