// Any block of any level through the filters that need no other blocks: decoding gives the encoded
// block, encoding gives the decoded bytes, and no byte outside the block is read or written.
//
// Input: filter, type, components, level, edges, a block, shapes of edges; then the block's bytes.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "chosen.h"
#include "compressed/block_coder.h"
#include "input_bytes.h"
#include "oracle.h"
#include "plait/registry.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

SlotShapes take_shapes(InputBytes& input, std::uint64_t edge_count) {
  std::vector<EdgeId> half, absent;
  const auto shapes = input.take<std::uint64_t>();
  for (EdgeId edge = 0; edge < edge_count; ++edge) {
    const std::uint64_t shape = shapes >> 2 * (edge % 32) & 3;
    if (shape == 2) half.push_back(edge);
    if (shape == 3) absent.push_back(edge);
  }
  return {edge_count, EdgeSet(half), EdgeSet(absent)};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  constexpr std::array pipelines = {"columns,none",         "shuffle,none",
                                    "columns+shuffle,none", "lattice:2e-6,none",
                                    "lattice:1e-36,none",   "lattice:0.1+columns,none"};
  constexpr std::array types = {ComponentType::kFloat32, ComponentType::kFloat64,
                                ComponentType::kInt8,    ComponentType::kInt16,
                                ComponentType::kUint32,  ComponentType::kInt64};
  const char* const pipeline = pipelines[take_choice(input, pipelines)];
  FilterLevel level;
  level.schema.type = types[input.take_below(types.size())];
  level.schema.components = static_cast<std::uint32_t>(1 + input.take_below(17));
  level.level = static_cast<int>(1 + input.take_below(6));
  const std::uint64_t edge_count = 1 + input.take_below(100);
  const std::size_t chosen = input.take<std::uint8_t>();
  const LevelGeometry geometry(take_shapes(input, edge_count), BaseRelativeLevel(level.level),
                               level.schema.record_bytes(), 4096);
  level.geometry = &geometry;
  if (geometry.block_count() == 0) return 0;
  const std::uint64_t block = chosen % geometry.block_count();
  ExactBytes raw(geometry.block_bytes(block));
  const std::span<const std::byte> rest = input.rest();
  std::ranges::copy(rest.first(std::min(rest.size(), raw.span().size())), raw.span().begin());

  Filters filters;
  if (!accepts({ErrorCode::kNotSupported},
               [&] { filters = default_pipelines().open(pipeline, level).filters; }))
    return 0;
  for (const auto& filter : filters) {
    ExactBytes scratch(filter->scratch_bytes()), other(raw.span().size()), back(raw.span().size());
    const FilterBlock with{block, {}, scratch.span()};
    filter->encode(with, raw.span(), other.span());
    filter->decode(with, other.span(), back.span());
    require(std::ranges::equal(raw.span(), back.span()));
    filter->decode(with, raw.span(), other.span());
    filter->encode(with, other.span(), back.span());
    require(std::ranges::equal(raw.span(), back.span()));
  }
  return 0;
}
