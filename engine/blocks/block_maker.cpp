#include "plait/extend/block_maker.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::optional<RecipeSource> source_in(std::string_view recipe) noexcept {
  const std::size_t first = recipe.find('/'), last = recipe.rfind('/');
  if (first == last || recipe.find('/', first + 1) != last) return std::nullopt;
  RecipeSource source{recipe.substr(0, first), recipe.substr(first + 1, last - first - 1), 0};
  const char* const end = recipe.data() + recipe.size();
  const auto [rest, error] = std::from_chars(recipe.data() + last + 1, end, source.levels);
  if (error != std::errc() || rest != end || source.levels < 1 || source.levels > kMaxLevel ||
      source.rule.empty() || source.attribute.empty())
    return std::nullopt;
  return source;
}

std::uint64_t block_bytes_of_level(const Pipeline& pipeline, int refinements,
                                   std::uint64_t block_bytes) {
  const auto source = pipeline.recipe ? source_in(*pipeline.recipe) : std::nullopt;
  if (!source) return block_bytes;
  // A slot has four times the bytes on the next level. A quarter of the source's edges in a block
  // needs few blocks of the source even where these meet.
  const int shift = 2 + 2 * std::clamp(source->levels - refinements, 0, kMaxLevel);
  return std::max<std::uint64_t>(block_bytes >> shift, 1);
}

PLAIT_END_NAMESPACE
