// backends/compressed/filters/residuals.h: the difference between a number and its prediction, such
// that any number and any prediction give the number back, bit for bit.
//
// Let m(x) be the bits of x, with the sign bit changed if it was 0 and all bits changed if it
// was 1. m keeps the order of numbers, so numbers that are near each other have integers near each
// other. The residual is zigzag(m(x) - m(prediction)), modulo 2^32 or 2^64: 0, -1, 1, -2 become 0,
// 1, 2, 3. A prediction that is not a number counts as 0, because processors disagree about the
// bits of a computed NaN.
//
// Pinned by tests/backends/compressed/filters/single_numbers_test.cpp.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "compressed/filters/ordered_words.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Number>
using BitsOf = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
template <class Number>
inline constexpr int kBitsOf = 8 * sizeof(Number);

/// m(p) of the head of this file.
template <class Number>
constexpr BitsOf<Number> ordered_prediction(Number prediction) {
  const Number counted = prediction == prediction ? prediction : Number{0};
  return FloatOrder::to<kBitsOf<Number>>(std::bit_cast<BitsOf<Number>>(counted));
}

template <class Number>
constexpr BitsOf<Number> residual(Number number, Number prediction) {
  const auto bits = std::bit_cast<BitsOf<Number>>(number);
  return zigzag<kBitsOf<Number>>(FloatOrder::to<kBitsOf<Number>>(bits) -
                                 ordered_prediction(prediction));
}

/// The number with this residual: the inverse of residual() for the same prediction.
template <class Number>
constexpr Number from_residual(BitsOf<Number> residual, Number prediction) {
  return std::bit_cast<Number>(FloatOrder::from<kBitsOf<Number>>(
      ordered_prediction(prediction) + from_zigzag<kBitsOf<Number>>(residual)));
}

PLAIT_END_NAMESPACE
