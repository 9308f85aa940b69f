// backends/compressed/filters/residuals.h: the difference between a number and its prediction, such
// that any number and any prediction give the number back, bit for bit.
//
// Let m(x) be the bits of x, with the sign bit changed if it was 0 and all bits changed if it
// was 1. m keeps the order of numbers, so numbers that are near each other have integers near each
// other. The residual is zigzag(m(x) - m(prediction)), modulo 2^32 or 2^64: 0, -1, 1, -2 become 0,
// 1, 2, 3. A prediction that is not a number counts as 0, because processors disagree about the
// bits of a computed NaN.
//
// Pinned by tests/backends/compressed/filters/residuals_test.cpp.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Number>
using BitsOf = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;

/// m(x) of the head of this file.
template <class Number>
constexpr BitsOf<Number> ordered_bits(Number number) {
  using Bits = BitsOf<Number>;
  using Signed = std::make_signed_t<Bits>;
  constexpr int kSignShift = 8 * sizeof(Bits) - 1;
  constexpr Bits kSign = Bits{1} << kSignShift;
  const auto bits = std::bit_cast<Bits>(number);
  return bits ^ (static_cast<Bits>(static_cast<Signed>(bits) >> kSignShift) | kSign);
}

/// The inverse of ordered_bits().
template <class Number>
constexpr Number from_ordered_bits(BitsOf<Number> ordered) {
  using Bits = BitsOf<Number>;
  using Signed = std::make_signed_t<Bits>;
  constexpr int kSignShift = 8 * sizeof(Bits) - 1;
  constexpr Bits kSign = Bits{1} << kSignShift;
  return std::bit_cast<Number>(
      ordered ^ (~static_cast<Bits>(static_cast<Signed>(ordered) >> kSignShift) | kSign));
}

template <class Number>
constexpr Number or_zero_if_nan(Number prediction) {
  return prediction == prediction ? prediction : Number{0};
}

template <class Number>
constexpr BitsOf<Number> residual(Number number, Number prediction) {
  using Bits = BitsOf<Number>;
  using Signed = std::make_signed_t<Bits>;
  const Bits difference = ordered_bits(number) - ordered_bits(or_zero_if_nan(prediction));
  const auto sign = static_cast<Bits>(static_cast<Signed>(difference) >> (8 * sizeof(Bits) - 1));
  return static_cast<Bits>(difference << 1) ^ sign;
}

/// The number with this residual: the inverse of residual() for the same prediction.
template <class Number>
constexpr Number from_residual(BitsOf<Number> residual, Number prediction) {
  using Bits = BitsOf<Number>;
  const Bits difference = static_cast<Bits>(residual >> 1) ^ (Bits{0} - (residual & 1));
  return from_ordered_bits<Number>(
      static_cast<Bits>(ordered_bits(or_zero_if_nan(prediction)) + difference));
}

PLAIT_END_NAMESPACE
