// backends/compressed/filters/ordered_words.h: residuals.h for words of every size, and for vectors
// of them: floating-point numbers as unsigned integers of the same order, and differences of such
// integers as small unsigned numbers. All functions are bijections of words, so a filter that is
// made of them is exact for every bit pattern: NaNs with their payloads, infinities and -0 too.
// Word is std::uint8_t to std::uint64_t, or a vector of std::uint32_t or std::uint64_t (GCC's
// vector_size); for a vector, kBits counts those of a lane. docs/filters/lorenzo.md has the
// formulas. Pinned by tests/backends/compressed/filters/ordered_words_test.cpp.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Integers, signed or not: differences do not depend on the sign, so there is nothing to map.
struct IntegerOrder {
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word to(Word bits) noexcept {
    return bits;
  }
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word from(Word ordered) noexcept {
    return ordered;
  }
};

/// IEEE numbers: the sign bit of a positive number is set, all bits of a negative one are turned.
struct FloatOrder {
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word to(Word bits) noexcept {
    constexpr auto kSign = std::uint64_t{1} << (kBits - 1);
    const Word all_if_negative = Word{} - (bits >> (kBits - 1));
    return bits ^ (all_if_negative | word<Word>(kSign));
  }
  template <int kBits, class Word>
  [[gnu::always_inline]] static constexpr Word from(Word ordered) noexcept {
    constexpr auto kSign = std::uint64_t{1} << (kBits - 1);
    const Word all_if_negative = (ordered >> (kBits - 1)) - word<Word>(1);
    return ordered ^ (all_if_negative | word<Word>(kSign));
  }

 private:
  template <class Word>
  [[gnu::always_inline]] static constexpr auto word(std::uint64_t value) noexcept {
    if constexpr (std::numeric_limits<Word>::is_integer)
      return static_cast<Word>(value);
    else  // the type of a lane
      return static_cast<std::remove_cvref_t<decltype(Word{}[0])>>(value);
  }
};

/// The difference of two words, as a signed number, with its sign in the lowest bit: 0, -1, 1, -2,
/// ... become 0, 1, 2, 3, ...
template <int kBits, class Word>
[[gnu::always_inline]] constexpr Word zigzag(Word difference) noexcept {
  if constexpr (std::numeric_limits<Word>::is_integer)
    return static_cast<Word>(
        static_cast<Word>(difference << 1) ^
        static_cast<Word>(Word{0} - static_cast<Word>(difference >> (kBits - 1))));
  else
    return (difference << 1) ^ (Word{} - (difference >> (kBits - 1)));
}
template <int kBits, class Word>
[[gnu::always_inline]] constexpr Word from_zigzag(Word number) noexcept {
  if constexpr (std::numeric_limits<Word>::is_integer)
    return static_cast<Word>(static_cast<Word>(number >> 1) ^
                             static_cast<Word>(Word{0} - static_cast<Word>(number & 1)));
  else
    return (number >> 1) ^ (Word{} - (number & 1));
}

PLAIT_END_NAMESPACE
