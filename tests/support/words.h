// tests/support/words.h: the words of 32 bits, for what holds of every float.
#pragma once

#include <cstdint>
#include <cstdlib>

#include "support/sanitized.h"

namespace plait::test {

/// Calls check(word) with words of every sign, exponent and NaN, some hundred words apart. With
/// PLAIT_LONG=1 in the environment with all 2^32. Returns how many checks returned false.
template <class Check>
std::uint64_t count_wrong_words(const Check& check) {
  constexpr std::uint64_t kApart = unless_sanitized(251, 16'381);  // primes: all low bits occur
  const std::uint64_t apart = std::getenv("PLAIT_LONG") ? 1 : kApart;
  std::uint64_t wrong = 0;
  for (std::uint64_t word = 0; word < std::uint64_t{1} << 32; word += apart)
    wrong += !check(static_cast<std::uint32_t>(word));
  return wrong;
}

}  // namespace plait::test
