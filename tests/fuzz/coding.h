// tests/fuzz/coding.h: the pipeline and component size that the first bytes of an input choose.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include "chosen.h"
#include "compressed/block_coder.h"
#include "input_bytes.h"
#include "plait/registry.h"

namespace plait::fuzz {

struct CodingInput {
  std::string pipeline;
  FilterLevel level;

  Filters filters() const { return default_pipelines().open(pipeline, level).filters; }
  std::unique_ptr<Codec> codec() const {
    return default_pipelines().make_codec(Pipeline(pipeline).codec);
  }
  BlockCoder coder(std::size_t most_bytes) const { return {codec(), most_bytes, 2, 0}; }
};

inline CodingInput take_coding(InputBytes& input) {
  constexpr std::array codecs = {"none", "lz4", "zstd", "zstd:-5", "zstd:1", "zstd:19", "bitpack"};
  constexpr std::array filters = {"none", "shuffle"};
  const std::string codec = codecs[take_choice(input, codecs)];
  const std::string filter = filters[input.take_below(filters.size())];
  constexpr std::array types = {ComponentType::kInt8, ComponentType::kInt16,
                                ComponentType::kFloat32, ComponentType::kFloat64};
  CodingInput coding{filter + ',' + codec, {}};
  coding.level.schema.type = types[input.take_below(types.size())];
  return coding;
}

}  // namespace plait::fuzz
