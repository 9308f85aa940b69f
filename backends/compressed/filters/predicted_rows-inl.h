// The loops of slot_predictions.h for vertices. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_ROWS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_ROWS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

#include "compressed/filters/residual_vectors-inl.h"
#include "compressed/filters/slot_predictions.h"

HWY_BEFORE_NAMESPACE();
namespace plait::slot_predictions::HWY_NAMESPACE {

/// The points around the vertices of one row. Each pointer is at the point with its name for column
/// 0, so the same index leads to the points for other columns.
template <class Number>
struct RowPoints {
  const Number *a, *b, *c, *d, *wing_ac, *wing_db, *wing_cb, *wing_ad;
  /// The next points on the line AB, beyond A and beyond B; and on the lines through C and D.
  const Number *beyond_a, *beyond_b, *c_a, *c_b, *d_a, *d_b;

  RowPoints(const PredictedRows<Number>& rows, std::int64_t row) {
    const auto at = [&](std::int64_t p, std::int64_t q) {
      return rows.points + (row + p) * rows.stride + q * rows.components;
    };
    a = at(0, 1), b = at(1, 0), c = at(0, 0), d = at(1, 1);
    wing_ac = at(-1, 1), wing_db = at(2, 0), wing_cb = at(1, -1), wing_ad = at(0, 2);
    beyond_a = at(-1, 2), beyond_b = at(2, -1);
    c_a = at(-2, 2), c_b = at(2, -2), d_a = at(-1, 3), d_b = at(3, -1);
  }

  template <class D>
  HWY_INLINE static hn::Vec<D> sum(D tag, const Number* first, const Number* second,
                                   std::int64_t i) {
    return hn::Add(hn::LoadU(tag, first + i), hn::LoadU(tag, second + i));
  }
  template <class D>
  HWY_INLINE static hn::Vec<D> scaled(D tag, double factor, hn::Vec<D> vector) {
    return hn::Mul(hn::Set(tag, static_cast<Number>(factor)), vector);
  }
  template <class D>
  HWY_INLINE hn::Vec<D> wings(D tag, std::int64_t i) const {
    return hn::Add(sum(tag, wing_ac, wing_db, i), sum(tag, wing_cb, wing_ad, i));
  }
  template <class D>
  HWY_INLINE hn::Vec<D> midpoint(D tag, std::int64_t i) const {
    return scaled(tag, 0.5, sum(tag, a, b, i));
  }
  template <class D>
  HWY_INLINE hn::Vec<D> butterfly(D tag, std::int64_t i) const {
    return hn::Sub(hn::Add(midpoint(tag, i), scaled(tag, 0.125, sum(tag, c, d, i))),
                   scaled(tag, 0.0625, wings(tag, i)));
  }
  /// The large term is added last, so that the small ones lose few bits.
  template <class D>
  HWY_INLINE hn::Vec<D> loop(D tag, std::int64_t i) const {
    const auto line = sum(tag, a, b, i);
    const auto near =
        hn::Add(scaled(tag, 5.0 / 64, sum(tag, c, d, i)), scaled(tag, 3.0 / 64, line));
    const auto around = hn::Add(wings(tag, i), sum(tag, beyond_a, beyond_b, i));
    const auto far = hn::Add(sum(tag, c_a, c_b, i), sum(tag, d_a, d_b, i));
    return hn::Add(scaled(tag, 0.5, line), hn::Add(hn::Sub(near, scaled(tag, 3.0 / 64, around)),
                                                   scaled(tag, 1.0 / 128, far)));
  }
};

/// The last record of a row of a border edge's slot.
template <class Number, class Finish>
HWY_INLINE void border_record(const PredictedRows<Number>& rows, std::int64_t row,
                              const RowPoints<Number>& points, const Finish& finish) {
  const hn::CappedTag<Number, 1> one;
  const bool inside = row > 0 && row + 1 < rows.side;
  const std::int64_t first = (rows.side - 1 - row) * rows.components;
  for (std::int64_t i = first; i < first + rows.components; ++i) {
    const auto middle = points.sum(one, points.a, points.b, i);
    finish(one, i,
           inside ? hn::Sub(points.scaled(one, 0.5625, middle),
                            points.scaled(one, 0.0625,
                                          points.sum(one, points.beyond_a, points.beyond_b, i)))
                  : points.scaled(one, 0.5, middle));
  }
}

/// One row by the Loop rule, where its points are known, and else by Butterfly.
template <class D, class Number, class Finish>
HWY_INLINE void loop_row(D d, const PredictedRows<Number>& rows, std::int64_t row,
                         std::int64_t count, const RowPoints<Number>& points,
                         const Finish& finish) {
  const auto butterfly = [&](auto tag, std::int64_t i)
                             HWY_ATTR { finish(tag, i, points.butterfly(tag, i)); };
  const std::int64_t first = rows.components,
                     end = std::min(count, (rows.side - 1) * rows.components);
  if (row == 0 || row + 1 >= rows.side || end <= first) return in_vectors(d, 0, count, butterfly);
  // Both ends by Butterfly, in whole vectors; the middle is written over what they have too much.
  const std::int64_t both =
      std::min(count, std::max(first, static_cast<std::int64_t>(hn::Lanes(d))));
  in_vectors(d, 0, both, butterfly);
  in_vectors(d, count - both, count, butterfly);
  in_vectors(d, first, end,
             [&](auto tag, std::int64_t i) HWY_ATTR { finish(tag, i, points.loop(tag, i)); });
}

template <class Number, class Finish>
HWY_INLINE void finish_rows(const PredictedRows<Number>& rows, Finish finish) {
  const hn::ScalableTag<Number> d;
  for (std::int64_t row = 0; row < rows.side; ++row) {
    const std::int64_t records = rows.slot.records(rows.side, row);
    const std::int64_t count = rows.slot.inside(rows.side, row) * rows.components;
    const RowPoints<Number> points(rows, row);
    if (rows.rule == PredictionRule::kMidpoint) {
      in_vectors(d, 0, records * rows.components, [&](auto tag, std::int64_t i) HWY_ATTR {
        finish(tag, i, points.midpoint(tag, i));
      });
    } else {
      if (rows.rule == PredictionRule::kLoop)
        loop_row(d, rows, row, count, points, finish);
      else
        in_vectors(d, 0, count, [&](auto tag, std::int64_t i) HWY_ATTR {
          finish(tag, i, points.butterfly(tag, i));
        });
      if (rows.slot.border) border_record(rows, row, points, finish);
    }
    finish = finish.advanced(records * rows.components);
  }
}

template <class Number>
HWY_INLINE void recode_slot(const PredictedRows<Number>& rows, const BitsOf<Number>* from,
                            BitsOf<Number>* to, Recode recode) {
  recode == Recode::kEncode ? finish_rows(rows, Recoder<Number, true>{from, to})
                            : finish_rows(rows, Recoder<Number, false>{from, to});
}
inline void recode_floats(const PredictedRows<float>& rows, const std::uint32_t* from,
                          std::uint32_t* to, Recode recode) {
  recode_slot(rows, from, to, recode);
}
inline void recode_doubles(const PredictedRows<double>& rows, const std::uint64_t* from,
                           std::uint64_t* to, Recode recode) {
  recode_slot(rows, from, to, recode);
}
inline void predict_floats(const PredictedRows<float>& rows, float* predictions) {
  finish_rows(rows, Predict<float>{predictions});
}
inline void predict_doubles(const PredictedRows<double>& rows, double* predictions) {
  finish_rows(rows, Predict<double>{predictions});
}

}  // namespace plait::slot_predictions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_PREDICTED_ROWS_INL_H
