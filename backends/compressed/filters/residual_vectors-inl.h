// residuals.h for vectors of one instruction set, and loops over numbers. Included once for each
// instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_RESIDUAL_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_RESIDUAL_VECTORS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_RESIDUAL_VECTORS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_RESIDUAL_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "compressed/filters/residuals.h"

HWY_BEFORE_NAMESPACE();
namespace plait::slot_predictions::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
using Words = hn::RebindToUnsigned<D>;
template <class D>
using WordsOf = hn::Vec<Words<D>>;

/// All bits of a lane set if its highest bit is.
template <class D>
HWY_INLINE WordsOf<D> spread_sign(D, WordsOf<D> words) {
  const hn::RebindToSigned<D> integers;
  return hn::BitCast(Words<D>(), hn::BroadcastSignBit(hn::BitCast(integers, words)));
}
template <class D>
HWY_INLINE WordsOf<D> sign_bit(D) {
  return hn::Set(Words<D>(), hn::TFromD<Words<D>>{1} << (8 * sizeof(hn::TFromD<D>) - 1));
}

/// As FloatOrder::to(), and for predictions as ordered_prediction().
template <class D>
HWY_INLINE WordsOf<D> ordered(D d, WordsOf<D> bits) {
  return hn::Xor(bits, hn::Or(spread_sign(d, bits), sign_bit(d)));
}
template <class D>
HWY_INLINE WordsOf<D> ordered_prediction_of(D d, hn::Vec<D> prediction) {
  const auto counted = hn::IfThenElseZero(hn::Eq(prediction, prediction), prediction);
  return ordered(d, hn::BitCast(Words<D>(), counted));
}

/// As FloatOrder::from().
template <class D>
HWY_INLINE WordsOf<D> bits_of(D d, WordsOf<D> number) {
  // A set highest bit belongs to a positive number.
  return hn::Xor(number, hn::Or(hn::Not(spread_sign(d, number)), sign_bit(d)));
}

/// As zigzag() and from_zigzag().
template <class D>
HWY_INLINE WordsOf<D> zigzag_of(D d, WordsOf<D> difference) {
  return hn::Xor(hn::Add(difference, difference), spread_sign(d, difference));
}
template <class D>
HWY_INLINE WordsOf<D> difference_of(D, WordsOf<D> zigzag) {
  const Words<D> words;
  const auto odd = hn::And(zigzag, hn::Set(words, 1));
  return hn::Xor(hn::ShiftRight<1>(zigzag), hn::Sub(hn::Zero(words), odd));
}

/// The residual of a number that is given as bits, or the bits of the number again. `place`: the
/// prediction as an integer.
template <bool kEncodes, class D>
HWY_INLINE WordsOf<D> recoded_at(D d, WordsOf<D> word, WordsOf<D> place) {
  if constexpr (kEncodes)
    return zigzag_of(d, hn::Sub(ordered(d, word), place));
  else
    return bits_of(d, hn::Add(place, difference_of(d, word)));
}
template <bool kEncodes, class D>
HWY_INLINE WordsOf<D> recoded(D d, WordsOf<D> word, hn::Vec<D> prediction) {
  return recoded_at<kEncodes>(d, word, ordered_prediction_of(d, prediction));
}

/// Writes the residuals of numbers, or the numbers of residuals.
template <class Number, bool kEncodes>
struct Recoder {
  const BitsOf<Number>* from;
  BitsOf<Number>* to;

  template <class D>
  HWY_INLINE void operator()(D d, std::int64_t i, hn::Vec<D> prediction) const {
    const Words<D> words;
    hn::StoreU(recoded<kEncodes>(d, hn::LoadU(words, from + i), prediction), words, to + i);
  }
  Recoder advanced(std::int64_t numbers) const { return {from + numbers, to + numbers}; }
};

/// Writes the predictions themselves.
template <class Number>
struct Predict {
  Number* to;

  template <class D>
  HWY_INLINE void operator()(D d, std::int64_t i, hn::Vec<D> prediction) const {
    hn::StoreU(prediction, d, to + i);
  }
  Predict advanced(std::int64_t numbers) const { return {to + numbers}; }
};

/// Calls visit(tag, i) for vectors that cover the numbers from `first` to `end`, and nothing else.
/// The last vector may overlap the one before; few numbers take shorter vectors. So visit() must
/// not read what it writes.
template <class D, class Visit>
HWY_INLINE void in_vectors(D d, std::int64_t first, std::int64_t end, const Visit& visit) {
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  if (end - first >= lanes) {
    for (; first + lanes <= end; first += lanes) visit(d, first);
    if (first < end) visit(d, end - lanes);
  } else if constexpr (hn::MaxLanes(D()) > 1) {
    in_vectors(hn::Half<D>(), first, end, visit);
  }
}

}  // namespace plait::slot_predictions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_RESIDUAL_VECTORS_INL_H
