// The place of a floating-point number among all numbers of its type, as an integer: numbers that
// are near each other have places near each other. docs/format.md, base.mesh.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Number>
using WordOf = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
template <class Number>
inline constexpr WordOf<Number> kSignOf = WordOf<Number>{1} << (8 * sizeof(Number) - 1);

/// The bits of x, all of them changed if its sign bit is 1, else only the sign bit.
template <class Number>
constexpr WordOf<Number> place_of(Number x) {
  const auto bits = std::bit_cast<WordOf<Number>>(x);
  return (bits & kSignOf<Number>) != 0 ? ~bits : bits ^ kSignOf<Number>;
}
/// The inverse.
template <class Number>
constexpr Number number_at(WordOf<Number> place) {
  return std::bit_cast<Number>((place & kSignOf<Number>) != 0 ? place ^ kSignOf<Number> : ~place);
}

PLAIT_END_NAMESPACE
