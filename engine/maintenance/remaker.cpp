#include "maintenance/remaker.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/damage.h"
#include "maintenance/read_block.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

const AttributeInfo& Remaker::info_of(const std::string& attribute) const {
  return *std::ranges::find_if(
      check_.attributes, [&](const AttributeInfo& each) { return each.schema.name == attribute; });
}

std::optional<std::span<const std::byte>> Remaker::block(const std::string& attribute,
                                                         const LevelFile& level,
                                                         std::uint64_t block) {
  bool is_made = false;
  for (const bool from_mesh : {true, false}) {
    if (!make(from_mesh, attribute, level.geometry, block)) continue;
    is_made = true;
    if (const auto stored = proven(info_of(attribute).schema, level, block)) return stored;
  }
  if (is_made) refusal_ = "what is made again is not what it held";
  return std::nullopt;
}

std::optional<std::span<const std::byte>> Remaker::base_records(const std::string& attribute) {
  const AttributeSchema& schema = info_of(attribute).schema;
  const LevelGeometry geometry =
      check_.base.geometry(BaseRelativeLevel(1), schema.record_bytes(), check_.options.block_bytes);
  Recipe& recipe = recipe_of(true, attribute, geometry);
  records_.resize(check_.base.vertex_count() * schema.record_bytes());
  const bool is_made = recipe.maker && recipe.maker->make_base(records_);
  refusal_ = recipe.refusal;
  recipe = {};  // it knows the level by the address of `geometry`
  return is_made ? std::optional<std::span<const std::byte>>(records_) : std::nullopt;
}

bool Remaker::make(bool from_mesh, const std::string& attribute, const LevelGeometry& geometry,
                   std::uint64_t block) {
  const Recipe& recipe = recipe_of(from_mesh, attribute, geometry);
  if (from_mesh) refusal_ = recipe.refusal;
  if (!recipe.maker) return false;
  records_.resize(geometry.block_bytes(block));
  try {
    std::span<std::byte> rest = records_;
    // Blocks of both sizes have a power of two of edges, so the smaller ones do not cross the ends.
    for (EdgeId edge = geometry.first_edge(block); edge < geometry.edge_after(block);) {
      const std::uint64_t part = recipe.geometry.block_of(edge);
      std::array<ContextBlock, kMostContextBlocks> needed;
      std::optional<PinnedContext> sources;
      if (const std::size_t count = recipe.maker->sources(part, needed); count > 0)
        sources.emplace(*store_, std::span(needed).first(count));
      recipe.maker->make(part,
                         sources ? sources->bytes() : std::span<const std::span<const std::byte>>(),
                         rest.first(recipe.geometry.block_bytes(part)));
      rest = rest.subspan(recipe.geometry.block_bytes(part));
      edge = recipe.geometry.edge_after(part);
    }
  } catch (const Error& error) {  // a block that it is made from is damaged
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotSupported) throw;
    if (from_mesh) refusal_ = without_cure(error);
    return false;
  }
  return true;
}

Remaker::Recipe& Remaker::recipe_of(bool from_mesh, const std::string& attribute,
                                    const LevelGeometry& stored) {
  Recipe& recipe = recipes_[from_mesh ? 1 : 0];
  if (recipe.stored == &stored) return recipe;
  const AttributeInfo& info = info_of(attribute);
  const int base_level = check_.provenance.base_level;
  // Without a scheme, a recipe makes blocks from other attributes.
  const Provenance made_by = from_mesh ? check_.provenance : Provenance{.base_level = base_level};
  recipe = {&stored};
  recipe.refusal =
      made_by.scheme.empty()
          ? fmt::format(
                "no scheme makes attribute '{}', which a pass, an import or a program has "
                "written: run that again on a whole store, or take a copy of the file",
                attribute)
          : fmt::format("no maker makes attribute '{}' again by scheme '{}'", attribute,
                        made_by.scheme);
  if (check_.base.depths() != nullptr || check_.depths_lost) {
    recipe.refusal = "its faces have depths of their own, and makers make all levels of all faces";
    return recipe;
  }
  Pipeline pipeline;
  if (makers_ && (from_mesh || store_ != nullptr))
    pipeline.recipe = makers_->recipe({info.schema, made_by, info.finest_level, !from_mesh});
  if (!pipeline.recipe || pipeline.recipe->empty() ||
      source_in(*pipeline.recipe).has_value() == from_mesh)
    return recipe;
  const auto id = static_cast<AttributeId>(&info - check_.attributes.data());
  recipe.geometry =
      from_mesh ? stored
                : check_.base.geometry(stored.level(), info.schema.record_bytes(),
                                       block_bytes_of_level(pipeline, stored.level().refinements,
                                                            check_.options.block_bytes));
  const LevelSurroundings surroundings{
      check_.base.topology(), base_level,
      from_mesh ? std::vector<AttributeLevels>() : attributes_before(id), check_.base.positions()};
  try {
    recipe.maker = makers_->open(
        {*pipeline.recipe, info.schema, from_mesh ? kNoId : id, recipe.geometry, surroundings});
  } catch (const Error& error) {
    recipe.refusal = without_cure(error);
  }
  return recipe;
}

/// Here an attribute's number is its AttributeId.
std::vector<AttributeLevels> Remaker::attributes_before(AttributeId attribute) const {
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

std::optional<std::span<const std::byte>> Remaker::proven(const AttributeSchema& schema,
                                                          const LevelFile& level,
                                                          std::uint64_t block) {
  const BlockEntry& expected = level.table[block];
  if (expected.encoding == BlockEncoding::kNeverWritten) return std::nullopt;
  if (expected.encoding == BlockEncoding::kRaw)
    return level.table.matches(block, records_)
               ? std::optional(std::span<const std::byte>(records_))
               : std::nullopt;
  if (model_of_ != &level) {
    model_of_ = nullptr;
    model_.reset();
    scratch_.directory().remove_if_possible(kModelName);
    table_ = level.table;
    std::ranges::fill(table_.entries(), BlockEntry{});
    volume_ = backend().open({});
    model_ = volume_->open_level({scratch_.directory(), kModelName, OpenMode::kCreate,
                                  level.geometry, table_, schema, level.pipeline});
    model_of_ = &level;
  }
  try {
    model_->write({block, 1}, records_);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotSupported) throw;
    return std::nullopt;  // the block is encoded from other blocks, so alone it proves nothing
  }
  const BlockEntry& found = table_[block];
  if (found.encoding != expected.encoding || found.stored_bytes != expected.stored_bytes ||
      found.checksum != expected.checksum)
    return std::nullopt;
  stored_.resize(found.stored_bytes);
  File(scratch_.directory(), kModelName, OpenMode::kRead).read_at(found.offset, stored_);
  return stored_;
}

PLAIT_END_NAMESPACE
