// Bits, and how many of them are set before each.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class RankedBits {
 public:
  static constexpr std::uint64_t bytes_for(std::uint64_t count) {
    return 8 * (count / 64 + 1) + 4 * (count / 64 / kWords + 1);
  }
  explicit RankedBits(std::uint64_t count) : words_(count / 64 + 1) {}

  void set(std::uint64_t bit) { words_[bit / 64] |= std::uint64_t{1} << bit % 64; }
  /// After all bits are set.
  void rank() {
    std::uint32_t sum = 0;
    ranks_.reserve(words_.size() / kWords + 1);
    for (std::size_t word = 0; word < words_.size(); ++word) {
      if (word % kWords == 0) ranks_.push_back(sum);
      sum += static_cast<std::uint32_t>(std::popcount(words_[word]));
    }
  }
  /// The number of set bits before this one.
  std::uint32_t before(std::uint64_t bit) const {
    std::size_t word = bit / 64 / kWords * kWords;
    std::uint32_t sum = ranks_[word / kWords];
    for (; word < bit / 64; ++word) sum += static_cast<std::uint32_t>(std::popcount(words_[word]));
    return sum + static_cast<std::uint32_t>(
                     std::popcount(words_[word] & ((std::uint64_t{1} << bit % 64) - 1)));
  }

 private:
  static constexpr std::size_t kWords = 8;  ///< for each rank that is kept

  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> ranks_;
};

PLAIT_END_NAMESPACE
