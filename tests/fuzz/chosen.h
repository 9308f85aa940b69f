// tests/fuzz/chosen.h: what an input chooses from a list of names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "input_bytes.h"

namespace plait::fuzz {

/// The index of the name that the environment variable PLAIT_FUZZ_ONLY has, so that all inputs of a
/// run go to one filter or preset; kCount without the variable.
template <std::size_t kCount>
std::size_t only_choice(const std::array<const char*, kCount>& names) {
  const char* const only = std::getenv("PLAIT_FUZZ_ONLY");
  if (only == nullptr) return kCount;
  for (std::size_t i = 0; i < kCount; ++i)
    if (std::string_view(only) == names[i]) return i;
  std::fprintf(stderr, "PLAIT_FUZZ_ONLY=%s: expected one of", only);
  for (const char* const name : names) std::fprintf(stderr, " %s", name);
  std::fprintf(stderr, "\n");
  std::exit(2);
}

/// The index of the name that the next byte of the input chooses, or that PLAIT_FUZZ_ONLY has. A
/// target calls it once for each input.
template <std::size_t kCount>
std::size_t take_choice(InputBytes& input, const std::array<const char*, kCount>& names) {
  static const std::size_t only = only_choice(names);
  const std::size_t chosen = input.take_below(kCount);
  return only < kCount ? only : chosen;
}

}  // namespace plait::fuzz
