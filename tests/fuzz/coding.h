// tests/fuzz/coding.h: the codecs, filters and component sizes that the first bytes of an input
// choose from.
#pragma once

#include <array>
#include <cstddef>

#include "input_bytes.h"

namespace plait::fuzz {

struct Coding {
  const char* codec;
  const char* filter;
  std::size_t component_bytes;
};

inline Coding take_coding(InputBytes& input) {
  constexpr std::array codecs = {"none", "lz4", "zstd", "zstd:-5", "zstd:1", "zstd:19"};
  constexpr std::array filters = {"none", "shuffle"};
  const char* const codec = codecs[input.take_below(codecs.size())];
  const char* const filter = filters[input.take_below(filters.size())];
  return {codec, filter, std::size_t{1} << input.take_below(4)};
}

}  // namespace plait::fuzz
