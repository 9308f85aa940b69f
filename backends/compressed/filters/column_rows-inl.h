// The loops of column_rows.h. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_COLUMN_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_COLUMN_ROWS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_COLUMN_ROWS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_COLUMN_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "compressed/filters/column_rows.h"
#include "compressed/filters/ordered_words.h"
#include "compressed/filters/residual_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plait::slot_predictions::HWY_NAMESPACE {

/// As many components of records, each in a vector of its own.
template <class D, std::size_t kComponents>
struct Components {
  hn::Vec<D> of[kComponents];

  static HWY_INLINE Components load(D d, const float* records) {
    Components c;
    if constexpr (kComponents == 1) c.of[0] = hn::LoadU(d, records);
    if constexpr (kComponents == 2) hn::LoadInterleaved2(d, records, c.of[0], c.of[1]);
    if constexpr (kComponents == 3) hn::LoadInterleaved3(d, records, c.of[0], c.of[1], c.of[2]);
    if constexpr (kComponents == 4)
      hn::LoadInterleaved4(d, records, c.of[0], c.of[1], c.of[2], c.of[3]);
    return c;
  }
  HWY_INLINE void store(D d, float* records) const {
    if constexpr (kComponents == 1) hn::StoreU(of[0], d, records);
    if constexpr (kComponents == 2) hn::StoreInterleaved2(of[0], of[1], d, records);
    if constexpr (kComponents == 3) hn::StoreInterleaved3(of[0], of[1], of[2], d, records);
    if constexpr (kComponents == 4) hn::StoreInterleaved4(of[0], of[1], of[2], of[3], d, records);
  }
};

/// Lane i of the result is lane i - kDistance of `words`. The first lanes are those of `former`,
/// which are all equal.
template <std::size_t kDistance, class D>
HWY_INLINE WordsOf<D> moved_up(D, WordsOf<D> words, WordsOf<D> former) {
  const Words<D> d;
  const auto lanes = hn::Iota(d, 0);
  const auto first = hn::Lt(lanes, hn::Set(d, kDistance));
  // Where no lane is before, any index does.
  const auto from = hn::IfThenElse(first, lanes, hn::Sub(lanes, hn::Set(d, kDistance)));
  return hn::IfThenElse(first, former, hn::TableLookupLanes(words, hn::IndicesFromVec(d, from)));
}

/// Each lane becomes the sum of itself and of all lanes before it.
template <std::size_t kDistance = 1, class D>
HWY_INLINE WordsOf<D> sums(D d, WordsOf<D> words) {
  if constexpr (kDistance < hn::MaxLanes(D()))
    return sums<2 * kDistance>(d,
                               hn::Add(words, moved_up<kDistance>(d, words, hn::Zero(Words<D>()))));
  else
    return words;
}

template <class D>
HWY_INLINE WordsOf<D> last_lane(D, WordsOf<D> words) {
  const Words<D> d;
  const auto last = hn::Set(d, static_cast<std::uint32_t>(hn::Lanes(d) - 1));
  return hn::TableLookupLanes(words, hn::IndicesFromVec(d, last));
}

/// One component of the first row, vector by vector. Its numbers are the sums of steps, and the
/// steps are the sums of what is stored.
template <class D>
struct FirstRow {
  /// In all lanes: the number before the next vector, as an integer, and the step to it.
  WordsOf<D> last, step;
  bool begins = true;  ///< no vector was before

  HWY_INLINE FirstRow(D, std::uint32_t before)
      : last(hn::Set(Words<D>(), FloatOrder::to<32>(before))), step(hn::Zero(Words<D>())) {}

  HWY_INLINE WordsOf<D> encode(D d, WordsOf<D> bits) {
    const auto x = ordered(d, bits);
    const auto jump_and_steps = hn::Sub(x, moved_up<1>(d, x, last));
    const auto steps = hn::Sub(jump_and_steps, jump(d, jump_and_steps));
    const auto differences = hn::Sub(jump_and_steps, moved_up<1>(d, steps, step));
    keep(d, x, steps);
    return zigzag_of(d, differences);
  }
  HWY_INLINE WordsOf<D> decode(D d, WordsOf<D> residuals) {
    const auto differences = difference_of(d, residuals);
    const auto first = jump(d, differences);
    const auto steps = hn::Add(sums(d, hn::Sub(differences, first)), step);
    const auto x = hn::Add(sums(d, hn::Add(steps, first)), last);
    keep(d, x, steps);
    return bits_of(d, x);
  }

 private:
  /// Of the row's first number, the step from the slot before, which is not continued; otherwise 0.
  HWY_INLINE WordsOf<D> jump(D, WordsOf<D> steps) const {
    const Words<D> d;
    if (!begins) return hn::Zero(d);
    return hn::IfThenElseZero(hn::Eq(hn::Iota(d, 0), hn::Zero(d)), steps);
  }
  HWY_INLINE void keep(D d, WordsOf<D> x, WordsOf<D> steps) {
    last = last_lane(d, x);
    step = last_lane(d, steps);
    begins = false;
  }
};

/// Encodes or decodes one row of the columns of one vector. `work(i, word)` gives the stored word
/// of component i from its bits, or its bits from the stored word. Returns the numbers.
template <bool kEncodes, std::size_t kComponents, class D, class Work>
HWY_INLINE Components<D, kComponents> do_row(D d, std::size_t side, std::uint32_t* words,
                                             float* numbers, const Work& work) {
  const Words<D> bits;
  if constexpr (kEncodes) {
    const auto row = Components<D, kComponents>::load(d, numbers);
    for (std::size_t i = 0; i < kComponents; ++i)
      hn::StoreU(work(i, hn::BitCast(bits, row.of[i])), bits, words + i * side);
    return row;
  } else {
    Components<D, kComponents> row;
    for (std::size_t i = 0; i < kComponents; ++i)
      row.of[i] = hn::BitCast(d, work(i, hn::LoadU(bits, words + i * side)));
    row.store(d, numbers);
    return row;
  }
}

/// Encodes or decodes the columns of one vector. `first_rows` has a row for each component.
template <bool kEncodes, std::size_t kComponents, class D>
HWY_INLINE void do_columns(D d, std::size_t side, std::uint32_t* words, float* numbers,
                           FirstRow<D>* first_rows) {
  const Words<D> bits;
  const auto by = [d](WordsOf<D> word, WordsOf<D> prediction)
                      HWY_ATTR { return recoded_at<kEncodes>(d, word, prediction); };
  auto two_above = do_row<kEncodes, kComponents>(
      d, side, words, numbers, [&](std::size_t i, WordsOf<D> word) HWY_ATTR {
        return kEncodes ? first_rows[i].encode(d, word) : first_rows[i].decode(d, word);
      });
  const std::size_t length = side * kComponents;
  auto above = do_row<kEncodes, kComponents>(
      d, side, words += length, numbers += length, [&](std::size_t i, WordsOf<D> word) HWY_ATTR {
        return by(word, ordered(d, hn::BitCast(bits, two_above.of[i])));
      });
  for (std::size_t row = 2; row < side; ++row) {
    const auto found = do_row<kEncodes, kComponents>(
        d, side, words += length, numbers += length, [&](std::size_t i, WordsOf<D> word) HWY_ATTR {
          const auto line = hn::Add(above.of[i], hn::Sub(above.of[i], two_above.of[i]));
          return by(word, ordered_prediction_of(d, line));
        });
    two_above = above;
    above = found;
  }
}

template <bool kEncodes, std::size_t kComponents, class D>
HWY_INLINE void in_slot(D d, std::size_t side, std::uint32_t* words, float* numbers,
                        std::uint32_t* before) {
  // One row for each component; those that are not there are not used.
  FirstRow<D> first_rows[] = {{d, before[0]},
                              {d, before[kComponents > 1 ? 1 : 0]},
                              {d, before[kComponents > 2 ? 2 : 0]},
                              {d, before[kComponents > 3 ? 3 : 0]}};
  for (std::size_t column = 0; column < side; column += hn::Lanes(d))
    do_columns<kEncodes, kComponents>(d, side, words + column, numbers + column * kComponents,
                                      first_rows);
  for (std::size_t i = 0; i < kComponents; ++i)
    std::memcpy(before + i, numbers + i, sizeof *before);
}

template <bool kEncodes, std::size_t kComponents>
void by_side(std::size_t side, std::uint32_t* words, float* numbers, std::uint32_t* before) {
  if (side == 4)
    in_slot<kEncodes, kComponents>(hn::CappedTag<float, 4>(), side, words, numbers, before);
  else if (side == 8)
    in_slot<kEncodes, kComponents>(hn::CappedTag<float, 8>(), side, words, numbers, before);
  else
    in_slot<kEncodes, kComponents>(hn::CappedTag<float, 16>(), side, words, numbers, before);
}

template <bool kEncodes>
void by_components(const ColumnSlot& slot, std::uint32_t* words, float* numbers,
                   std::uint32_t* before) {
  switch (slot.components) {
    case 1:
      return by_side<kEncodes, 1>(slot.side, words, numbers, before);
    case 2:
      return by_side<kEncodes, 2>(slot.side, words, numbers, before);
    case 3:
      return by_side<kEncodes, 3>(slot.side, words, numbers, before);
    default:
      return by_side<kEncodes, 4>(slot.side, words, numbers, before);
  }
}

inline bool has_rows(const ColumnSlot& slot) {
  return HWY_TARGET != HWY_SCALAR && slot.side >= 4 && slot.components <= 4;
}
inline void encode_rows(const ColumnSlot& slot, const float* numbers, std::uint32_t* words,
                        std::uint32_t* before) {
  by_components<true>(slot, words, const_cast<float*>(numbers), before);
}
inline void decode_rows(const ColumnSlot& slot, const std::uint32_t* words, float* numbers,
                        std::uint32_t* before) {
  by_components<false>(slot, const_cast<std::uint32_t*>(words), numbers, before);
}

}  // namespace plait::slot_predictions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_COLUMN_ROWS_INL_H
