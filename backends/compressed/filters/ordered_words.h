// backends/compressed/filters/ordered_words.h: floating-point numbers as unsigned integers of the
// same order, and differences of such integers as small unsigned numbers. All functions are
// bijections of words, so a filter that is made of them is exact for every bit pattern: NaNs with
// their payloads, infinities and -0 too. Word is std::uint32_t or std::uint64_t, and kBits its
// bits. docs/filters/columns.md has the formulas. Pinned by
// tests/backends/compressed/filters/single_numbers_test.cpp.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// IEEE numbers: the sign bit of a positive number is set, all bits of a negative one are turned.
struct FloatOrder {
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word to(Word bits) noexcept {
    const Word all_if_negative = Word{0} - (bits >> (kBits - 1));
    return bits ^ (all_if_negative | Word{1} << (kBits - 1));
  }
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word from(Word ordered) noexcept {
    const Word all_if_negative = (ordered >> (kBits - 1)) - Word{1};
    return ordered ^ (all_if_negative | Word{1} << (kBits - 1));
  }
};

/// The difference of two words, as a signed number, with its sign in the lowest bit: 0, -1, 1, -2,
/// ... become 0, 1, 2, 3, ...
template <int kBits, class Word>
[[gnu::always_inline]] constexpr Word zigzag(Word difference) noexcept {
  return (difference << 1) ^ (Word{0} - (difference >> (kBits - 1)));
}
template <int kBits, class Word>
[[gnu::always_inline]] constexpr Word from_zigzag(Word number) noexcept {
  return (number >> 1) ^ (Word{0} - (number & 1));
}

PLAIT_END_NAMESPACE
