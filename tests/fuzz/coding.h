// tests/fuzz/coding.h: the pipeline and component size that the first bytes of an input choose.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "input_bytes.h"

namespace plait::fuzz {

struct CodingInput {
  std::string pipeline;
  std::size_t component_bytes;
};

inline CodingInput take_coding(InputBytes& input) {
  constexpr std::array codecs = {"none", "lz4", "zstd", "zstd:-5", "zstd:1", "zstd:19"};
  constexpr std::array filters = {"none", "shuffle"};
  const std::string codec = codecs[input.take_below(codecs.size())];
  const std::string filter = filters[input.take_below(filters.size())];
  return {filter + ',' + codec, std::size_t{1} << input.take_below(4)};
}

}  // namespace plait::fuzz
