// Numbers in the form in which base.mesh has them (docs/format.md): planes of bytes, and
// differences as small numbers.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Numbers as planes of bytes: first the lowest byte of each number, then the second one, ...
template <class Word>
class Planes {
 public:
  explicit Planes(std::size_t count) : count_(count) {}
  std::size_t bytes() const { return count_ * sizeof(Word); }

  void put(std::byte* planes, std::size_t i, Word word) const {
    for (std::size_t plane = 0; plane < sizeof(Word); ++plane)
      planes[plane * count_ + i] = static_cast<std::byte>(word >> (8 * plane));
  }
  /// Calls visit(i, word) for all numbers in order. Takes many of each plane at once, in loops that
  /// compilers make vectors of.
  template <class Visit>
  void for_each(const std::byte* planes, Visit visit) const {
    constexpr std::size_t kMany = 512;
    std::array<Word, kMany> words;
    for (std::size_t first = 0; first < count_; first += kMany) {
      const std::size_t many = std::min(kMany, count_ - first);
      words.fill(0);
      for (std::size_t plane = 0; plane < sizeof(Word); ++plane) {
        const std::byte* const from = planes + plane * count_ + first;
        for (std::size_t i = 0; i < many; ++i)
          words[i] = static_cast<Word>(words[i] | std::to_integer<Word>(from[i]) << (8 * plane));
      }
      for (std::size_t i = 0; i < many; ++i) visit(first + i, words[i]);
    }
  }

 private:
  std::size_t count_;
};

/// Differences of either sign as small numbers: 0, -1, 1, -2 become 0, 1, 2, 3.
template <std::unsigned_integral Word>
constexpr Word zigzag(Word difference) {
  return static_cast<Word>(static_cast<Word>(difference << 1) ^
                           static_cast<Word>(0 - (difference >> (8 * sizeof(Word) - 1))));
}
template <std::unsigned_integral Word>
constexpr Word from_zigzag(Word number) {
  return static_cast<Word>((number >> 1) ^ static_cast<Word>(0 - (number & 1)));
}

PLAIT_END_NAMESPACE
