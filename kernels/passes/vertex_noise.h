// Numbers that look random and follow from what they are for: no generator has a state, so threads
// and orders of visits change nothing.
#pragma once

#include <algorithm>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Result `index` of the generator SplitMix64 whose state was `key` (G. Steele, D. Lea, C. Flood,
/// "Fast Splittable Pseudorandom Number Generators", 2014). Its state is a counter, so every result
/// can be computed alone.
constexpr std::uint64_t random_word(std::uint64_t key, std::uint64_t index) noexcept {
  std::uint64_t word = key + (index + 1) * 0x9e3779b97f4a7c15u;
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

/// The key of a slot, from what the digest knows of it. A base vertex has two equal ends.
constexpr std::uint64_t slot_key(std::uint64_t seed, VertexId start, VertexId end,
                                 int level) noexcept {
  const auto low = std::uint64_t{std::min(start, end)}, high = std::uint64_t{std::max(start, end)};
  return random_word(random_word(random_word(seed, 0), low << 32 | high),
                     static_cast<std::uint64_t>(level));
}

/// 2 u - 1 for a u that is uniform in [0, 1): 53 bits of a random word.
constexpr double from_minus_one_to_one(std::uint64_t word) noexcept {
  return static_cast<double>(word >> 11) * 0x1p-52 - 1;
}

PLAIT_END_NAMESPACE
