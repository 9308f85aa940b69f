// The loops of slot_predictions.h that predict two components of a vertex from the third. Included
// once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_ALONG_NORMALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_ALONG_NORMALS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_ALONG_NORMALS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_ALONG_NORMALS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "compressed/filters/predicted_rows-inl.h"
#include "compressed/filters/residual_vectors-inl.h"
#include "compressed/filters/slot_predictions.h"

HWY_BEFORE_NAMESPACE();
namespace plait::slot_predictions::HWY_NAMESPACE {

/// The components of a vertex, or of one in each lane: that of the axis, and the two after it.
template <class V>
struct Cycle {
  V axis, next, last;
};

template <std::size_t kAxis, class D, class Number>
HWY_INLINE Cycle<hn::Vec<D>> load_cycle(D d, const Number* from) {
  hn::Vec<D> x, y, z;
  if constexpr (hn::MaxLanes(D()) == 1)
    x = hn::LoadU(d, from), y = hn::LoadU(d, from + 1), z = hn::LoadU(d, from + 2);
  else
    hn::LoadInterleaved3(d, from, x, y, z);
  if constexpr (kAxis == 0) return {x, y, z};
  if constexpr (kAxis == 1) return {y, z, x};
  if constexpr (kAxis == 2) return {z, x, y};
}
template <std::size_t kAxis, class D, class Number>
HWY_INLINE void store_cycle(D d, const Cycle<hn::Vec<D>>& from, Number* to) {
  const auto store = [&](auto x, auto y, auto z) HWY_ATTR {
    if constexpr (hn::MaxLanes(D()) == 1)
      hn::StoreU(x, d, to), hn::StoreU(y, d, to + 1), hn::StoreU(z, d, to + 2);
    else
      hn::StoreInterleaved3(x, y, z, d, to);
  };
  if constexpr (kAxis == 0) store(from.axis, from.next, from.last);
  if constexpr (kAxis == 1) store(from.last, from.axis, from.next);
  if constexpr (kAxis == 2) store(from.next, from.last, from.axis);
}

/// The vertices of a row, from column 0 on.
template <class Number>
struct RowAlong {
  const Number *a, *b, *c, *d;  ///< as RowPoints
  const Number* predictions;
  const BitsOf<Number>* from;
  BitsOf<Number>* to;

  /// As many vertices as `tag` has lanes, from number `i` on.
  template <bool kEncodes, std::size_t kAxis, class D>
  HWY_INLINE void finish(D tag, std::int64_t i) const {
    const Words<D> words;
    // Subtracted before they are taken apart, which is what costs most.
    const auto difference = [&](const Number* end, const Number* start) HWY_ATTR {
      constexpr std::size_t kLanes = hn::MaxLanes(D());
      HWY_ALIGN Number between[3 * kLanes];
      for (std::size_t k = 0; k < 3 * kLanes; k += kLanes)
        hn::Store(hn::Sub(hn::LoadU(tag, end + i + k), hn::LoadU(tag, start + i + k)), tag,
                  between + k);
      return load_cycle<kAxis>(tag, between);
    };
    const auto u = difference(a, b), v = difference(c, d);
    const auto axis = hn::Sub(hn::Mul(u.next, v.last), hn::Mul(u.last, v.next)),
               next = hn::Sub(hn::Mul(u.last, v.axis), hn::Mul(u.axis, v.last)),
               last = hn::Sub(hn::Mul(u.axis, v.next), hn::Mul(u.next, v.axis));
    const auto inverse = hn::Div(hn::Set(tag, 1), axis);
    const auto slope = [&](auto component) HWY_ATTR {
      const auto ratio = hn::Mul(component, inverse);
      return hn::IfThenElseZero(hn::Le(hn::Abs(ratio), hn::Set(tag, Number(kSteepestSlope))),
                                ratio);
    };
    const auto in = load_cycle<kAxis>(words, from + i);
    const auto predicted = load_cycle<kAxis>(tag, predictions + i);
    Cycle<WordsOf<D>> out;
    out.axis = recoded<kEncodes>(tag, in.axis, predicted.axis);
    const auto way = hn::Sub(hn::BitCast(tag, kEncodes ? in.axis : out.axis), predicted.axis);
    out.next = recoded<kEncodes>(tag, in.next, hn::Add(predicted.next, hn::Mul(way, slope(next))));
    out.last = recoded<kEncodes>(tag, in.last, hn::Add(predicted.last, hn::Mul(way, slope(last))));
    store_cycle<kAxis>(words, out, to + i);
  }

  /// The last vectors may overlap; few vertices take shorter vectors, or come one by one.
  template <bool kEncodes, std::size_t kAxis, class D>
  HWY_INLINE void finish_all(D tag, std::int64_t count) const {
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(tag));
    if (count >= lanes) {
      std::int64_t i = 0;
      for (; i + lanes <= count; i += lanes) finish<kEncodes, kAxis>(tag, 3 * i);
      if (i < count) finish<kEncodes, kAxis>(tag, 3 * (count - lanes));
    } else if constexpr (hn::MaxLanes(D()) * sizeof(Number) > 16) {
      finish_all<kEncodes, kAxis>(hn::Half<D>(), count);
    } else {
      for (std::int64_t i = 0; i < count; ++i)
        finish<kEncodes, kAxis>(hn::CappedTag<Number, 1>(), 3 * i);
    }
  }

  /// A vertex on a border, where no face lies beyond: each component by itself.
  template <bool kEncodes>
  HWY_INLINE void finish_border(std::int64_t i) const {
    const hn::CappedTag<Number, 1> one;
    for (std::int64_t k = i; k < i + 3; ++k)
      Recoder<Number, kEncodes>{from, to}(one, k, hn::LoadU(one, predictions + k));
  }
};

/// The component in which the normal of the edge's own face is longest.
template <class Number>
int axis_of(const PredictedRows<Number>& rows) {
  const Number* const start = rows.points;
  const Number* const p = start + rows.side * rows.stride;
  const Number* const q = start + rows.side * rows.components;
  int axis = 0;
  Number longest = 0;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    const Number component = (q[next] - start[next]) * (p[last] - start[last]) -
                             (q[last] - start[last]) * (p[next] - start[next]);
    const Number length = component < 0 ? -component : component;
    if (length > longest) axis = k, longest = length;
  }
  return axis;
}

template <bool kEncodes, std::size_t kAxis, class Number>
HWY_INLINE void along_axis(const PredictedRows<Number>& rows, RowAlong<Number> along) {
  const hn::ScalableTag<Number> tag;
  for (std::int64_t row = 0; row < rows.side; ++row) {
    const RowPoints<Number> points(rows, row);
    along.a = points.a, along.b = points.b, along.c = points.c, along.d = points.d;
    const std::int64_t inside = rows.slot.inside(rows.side, row);
    along.template finish_all<kEncodes, kAxis>(tag, inside);
    if (rows.slot.border) along.template finish_border<kEncodes>(3 * inside);
    const std::int64_t numbers = 3 * rows.slot.records(rows.side, row);
    along.predictions += numbers, along.from += numbers, along.to += numbers;
  }
}

template <bool kEncodes, class Number>
HWY_INLINE void along_normals(const PredictedRows<Number>& rows, const Number* predictions,
                              const BitsOf<Number>* from, BitsOf<Number>* to) {
  const RowAlong<Number> along{nullptr, nullptr, nullptr, nullptr, predictions, from, to};
  switch (axis_of(rows)) {
    case 0:
      return along_axis<kEncodes, 0>(rows, along);
    case 1:
      return along_axis<kEncodes, 1>(rows, along);
    default:
      return along_axis<kEncodes, 2>(rows, along);
  }
}

inline void floats_along(const PredictedRows<float>& rows, const float* predictions,
                         const std::uint32_t* from, std::uint32_t* to, Recode recode) {
  recode == Recode::kEncode ? along_normals<true>(rows, predictions, from, to)
                            : along_normals<false>(rows, predictions, from, to);
}
inline void doubles_along(const PredictedRows<double>& rows, const double* predictions,
                          const std::uint64_t* from, std::uint64_t* to, Recode recode) {
  recode == Recode::kEncode ? along_normals<true>(rows, predictions, from, to)
                            : along_normals<false>(rows, predictions, from, to);
}

}  // namespace plait::slot_predictions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_ALONG_NORMALS_INL_H
