// Any block of any level through the filters that predict it from other blocks, whatever these
// contain: decoding gives the encoded block, encoding gives the decoded bytes, no byte outside the
// blocks is read or written, and decoding takes no more than ten times as long as that of a smooth
// surface.
//
// Input: filter, mesh, type of the records, level, block; then bytes that are repeated to fill the
// block, its context and the base records.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "bounded_work.h"
#include "chosen.h"
#include "compressed/block_coder.h"
#include "input_bytes.h"
#include "oracle.h"
#include "small_levels.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::array kFilters = {
    "hierarchy", "hierarchy:midpoint", "hierarchy:step=2e-6", "hierarchy:midpoint:step=0.1",
    "normals",   "normals:position",   "hierarchy:along"};
struct Type {
  ComponentType type;
  std::uint32_t components;
};
constexpr std::array<Type, 5> kTypes = {{{ComponentType::kFloat32, 3},
                                         {ComponentType::kFloat64, 3},
                                         {ComponentType::kFloat32, 1},
                                         {ComponentType::kFloat64, 4},
                                         {ComponentType::kFloat32, 2}}};

/// Levels of one type, and a filter for each level, which all inputs share.
struct Shared {
  Shared(std::size_t filter, std::size_t mesh, Type type)
      : levels(small_mesh(mesh),
               {{"position", type.type, type.components}, {"normal", ComponentType::kFloat32, 3}}),
        attribute(std::string_view(kFilters[filter]).starts_with("normals") ? 1 : 0) {
    for (int level = 1; level <= SmallLevels::kFinest; ++level)
      accepts({ErrorCode::kNotSupported}, [&] {
        filters.push_back(std::move(default_pipelines()
                                        .open(std::string(kFilters[filter]) + ",none",
                                              levels.filter_level(attribute, level))
                                        .filters.front()));
      });
  }
  SmallLevels levels;
  std::size_t attribute;
  std::vector<std::unique_ptr<Filter>> filters;  ///< [level - 1]; none for other types
  std::map<std::pair<int, std::uint64_t>, double> honest_seconds = {};
};

Shared& shared(std::size_t filter, std::size_t mesh, std::size_t type) {
  static std::map<std::tuple<std::size_t, std::size_t, std::size_t>, Shared> all;
  const auto key = std::tuple(filter, mesh, type);
  const auto found = all.find(key);
  if (found != all.end()) return found->second;
  return all.try_emplace(key, filter, mesh, kTypes[type]).first->second;
}

void fill(std::span<std::byte> to, std::span<const std::byte> from, std::size_t start) {
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = from.empty() ? std::byte{0} : from[(start + i) % from.size()];
}

/// Numbers near 1, as a surface has them: the bytes of floats that differ in the low bits.
void fill_honest(std::span<std::byte> to) {
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = i % 8 == 7   ? std::byte{0x3f}
            : i % 8 == 6 ? std::byte{0xf0}
            : i % 4 == 3 ? std::byte{0x3f}
                         : static_cast<std::byte>(i / 4);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const std::size_t chosen = take_choice(input, kFilters);
  const std::size_t mesh = input.take_below(kSmallMeshes + 1),
                    type = input.take_below(kTypes.size());
  const int level = static_cast<int>(1 + input.take_below(SmallLevels::kFinest));
  Shared& all = shared(chosen, mesh, type);
  if (all.filters.empty()) return 0;
  const Filter& filter = *all.filters[static_cast<std::size_t>(level - 1)];
  const LevelGeometry& geometry = all.levels.geometry(all.attribute, level);
  const std::uint64_t block = input.take<std::uint8_t>() % geometry.block_count();
  const std::span<const std::byte> rest = input.rest();

  ExactBytes raw(geometry.block_bytes(block)), other(raw.span().size()), back(raw.span().size()),
      scratch(filter.scratch_bytes());
  std::ranges::fill(scratch.span(), std::byte{0xa5});
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = filter.context(block, needed);
  const auto fill_context = [&](auto fill_one) {
    for (std::size_t attribute = 0; attribute < 2; ++attribute)
      fill_one(all.levels.base(attribute));
    for (const ContextBlock& each : std::span(needed).first(count))
      fill_one(all.levels.block(each.attribute, each.level, each.block));
  };
  double& honest = all.honest_seconds[{level, block}];
  if (honest == 0) {
    fill_context(fill_honest);
    fill_honest(other.span());
    const ContextBytes context(filter, all.levels, block);
    honest = fastest(10, [&] {
      filter.decode({block, context.spans(), scratch.span()}, other.span(), back.span());
    });
  }
  std::size_t start = 0;
  fill(raw.span(), rest, start);
  fill_context([&](std::span<std::byte> bytes) { fill(bytes, rest, start += 7); });
  const ContextBytes context(filter, all.levels, block);
  const FilterBlock with{block, context.spans(), scratch.span()};
  filter.encode(with, raw.span(), other.span());
  filter.decode(with, other.span(), back.span());
  require(std::ranges::equal(raw.span(), back.span()));
  require_time(honest, [&] { filter.decode(with, raw.span(), other.span()); });
  filter.encode(with, other.span(), back.span());
  require(std::ranges::equal(raw.span(), back.span()));
  return 0;
}
