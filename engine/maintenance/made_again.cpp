#include "maintenance/made_again.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/damage.h"
#include "maintenance/read_block.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

MadeAgain::Records MadeAgain::block(From from, const std::string& attribute,
                                    const LevelGeometry& geometry, std::uint64_t block) {
  const Level& level = level_of(from, attribute, geometry);
  if (!level.maker) return std::nullopt;
  const EdgeId after = geometry.edge_after(block);
  records_.resize(geometry.block_bytes(block));
  // Blocks of both sizes have a power of two of edges, so the smaller ones do not cross the ends.
  try {
    std::span<std::byte> rest = records_;
    for (EdgeId edge = geometry.first_edge(block); edge < after;) {
      const std::uint64_t part = level.geometry.block_of(edge);
      make(*level.maker, part, rest.first(level.geometry.block_bytes(part)));
      rest = rest.subspan(level.geometry.block_bytes(part));
      edge = level.geometry.edge_after(part);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotSupported) throw;
    if (from == From::kBaseMesh) refusal_ = without_cure(error);
    return std::nullopt;
  }
  return records_;
}

MadeAgain::Records MadeAgain::base_records(const std::string& attribute) {
  const auto info = std::ranges::find_if(
      check_.attributes, [&](const AttributeInfo& each) { return each.schema.name == attribute; });
  const LevelGeometry geometry = check_.base.geometry(
      BaseRelativeLevel(1), info->schema.record_bytes(), check_.options.block_bytes);
  Level& level = level_of(From::kBaseMesh, attribute, geometry);
  records_.resize(check_.base.vertex_count() * info->schema.record_bytes());
  const bool is_made = level.maker && level.maker->make_base(records_);
  if (level.maker && !is_made) refusal_ = "no maker makes its base records again";
  level = {};  // it knows the level by the address of `geometry`
  return is_made ? Records(records_) : std::nullopt;
}

MadeAgain::Level& MadeAgain::level_of(From from, const std::string& attribute,
                                      const LevelGeometry& stored) {
  Level& level = levels_[static_cast<std::size_t>(from)];
  if (level.stored == &stored && level.attribute == attribute) return level;
  level = {attribute, &stored};
  if (check_.base.edge_count() == 0) {
    refusal_ = "base.mesh, from which blocks are made again, is damaged";
    return level;
  }
  const bool from_mesh = from == From::kBaseMesh;
  const auto info = std::ranges::find_if(
      check_.attributes, [&](const AttributeInfo& each) { return each.schema.name == attribute; });
  const int base_level = check_.provenance.base_level;
  // Without a scheme, a recipe makes blocks from other attributes.
  const Provenance made_by = from_mesh ? check_.provenance : Provenance{.base_level = base_level};
  Pipeline pipeline;
  if (makers_ && (from_mesh || store_ != nullptr))
    pipeline.recipe = makers_->recipe({info->schema, made_by, info->finest_level, !from_mesh});
  if (from_mesh)
    refusal_ = fmt::format("no maker makes attribute '{}' again{}", attribute,
                           made_by.scheme.empty() ? ", and the manifest names no scheme"
                                                  : fmt::format(" by scheme '{}'", made_by.scheme));
  if (!pipeline.recipe || pipeline.recipe->empty() ||
      source_in(*pipeline.recipe).has_value() == from_mesh)
    return level;
  const auto id = static_cast<AttributeId>(info - check_.attributes.begin());
  level.geometry =
      from_mesh ? stored
                : check_.base.geometry(stored.level(), info->schema.record_bytes(),
                                       block_bytes_of_level(pipeline, stored.level().refinements,
                                                            check_.options.block_bytes));
  const LevelSurroundings surroundings{
      check_.base.topology(), base_level,
      from_mesh ? std::vector<AttributeLevels>() : attributes_before(id), check_.base.positions()};
  try {
    level.maker = makers_->open(
        {*pipeline.recipe, info->schema, from_mesh ? kNoId : id, level.geometry, surroundings});
  } catch (const Error& error) {
    if (from_mesh) refusal_ = without_cure(error);
  }
  return level;
}

/// Here an attribute's number is its AttributeId.
std::vector<AttributeLevels> MadeAgain::attributes_before(AttributeId attribute) const {
  std::vector<AttributeLevels> result;
  for (AttributeId id = 0; id < attribute; ++id) {
    const AttributeInfo& info = check_.attributes[id];
    AttributeLevels& levels = result.emplace_back();
    levels.number = id;
    levels.schema = info.schema;
    levels.base = std::as_const(*store_).base_bytes(id);
    for (int level = store_->base_level() + 1; level <= info.finest_level; ++level)
      levels.levels.push_back(&StoreAccess::level_file(*store_, id, level).geometry);
  }
  return result;
}

void MadeAgain::make(const BlockMaker& maker, std::uint64_t block, std::span<std::byte> records) {
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = maker.sources(block, needed);
  if (count == 0) return maker.make(block, {}, records);
  const PinnedContext sources(*store_, std::span(needed).first(count));
  maker.make(block, sources.bytes(), records);
}

PLAIT_END_NAMESPACE
