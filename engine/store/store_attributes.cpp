// The functions of a store that add, change and remove attributes and levels.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "plait/base_relative_level.h"
#include "plait/edge_index.h"
#include "plait/error.h"
#include "plait/level_pipelines.h"
#include "plait/store.h"
#include "store/store_checks.h"
#include "store/store_state.h"
#include "store/version_description.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether another attribute gets the name.
enum class Replaced : std::uint8_t { kNo, kYes };

/// Errors: kBadState if a written block of another attribute was encoded from `needed`, or if
/// another attribute is derived from it.
void check_not_needed_by_others(const Store::Implementation& state,
                                const Store::Implementation::Attribute& needed, Replaced replaced) {
  for (const auto& other : state.attributes) {
    if (&other == &needed) continue;
    const auto id = static_cast<std::size_t>(&needed - state.attributes.data());
    if (replaced == Replaced::kNo && other.derived &&
        other.derived->source() == state.infos[id].schema.name)
      throw Error(
          ErrorCode::kBadState,
          fmt::format(
              "remove '{}' of {}: '{}' is computed from it; store or remove that "
              "attribute first",
              state.infos[id].schema.name, state.path.native(),
              state.infos[static_cast<std::size_t>(&other - state.attributes.data())].schema.name));
    for (const auto& level : other.levels) {
      std::array<ContextBlock, kMostContextBlocks> blocks;
      const std::size_t count = level->backend->context(0, blocks);
      for (const ContextBlock& block : std::span(blocks).first(count))
        if (block.attribute == needed.record.number)
          throw Error(ErrorCode::kBadState,
                      fmt::format("remove an attribute of {}: {} is encoded from its levels",
                                  state.path.native(), level->path.native()));
    }
  }
}

}  // namespace

AttributeId Store::add_attribute(AttributeSchema schema) {
  Implementation& state = *implementation_;
  check_writable(state);
  if (!is_attribute_name(schema.name) || schema.record_bytes() == 0 || schema.components > 255)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': expected a name of 1 to {} characters of "
                            "[A-Za-z0-9_-] and 1 to 255 components",
                            schema.name, kMaxAttributeNameBytes));
  if (has_attribute(schema.name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': the name is taken", schema.name));
  if (attributes().size() >= kMaxAttributes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': expected fewer than {} attributes, found {}",
                            schema.name, kMaxAttributes, attributes().size()));
  if (state.next_number == std::numeric_limits<std::uint32_t>::max())
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("add attribute '{}': the store has used all attribute numbers", schema.name));
  std::string pipeline =
      state.options.pipeline_of ? state.options.pipeline_of(schema) : state.options.pipeline;
  pipeline = state.checked_pipeline(std::move(pipeline), schema);
  Implementation::Attribute attribute;
  attribute.record.number = state.next_number++;
  attribute.record.pipeline = std::move(pipeline);
  state.follow_pipeline(attribute, schema);
  state.attributes.push_back(std::move(attribute));
  state.infos.push_back({std::move(schema), base_level()});
  state.connect_derived();
  return static_cast<AttributeId>(state.infos.size() - 1);
}

AttributeId Store::add_attribute(AttributeSchema schema, int finest_level) {
  Implementation& state = *implementation_;
  if (finest_level < base_level() || finest_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}' with levels up to {}: expected {} to {}",
                            schema.name, finest_level, base_level(), kMaxLevel));
  const AttributeId id = add_attribute(std::move(schema));
  try {
    while (state.infos[id].finest_level < finest_level) add_level(id);
  } catch (...) {
    for (auto& level : state.attributes[id].levels) state.pager->detach(*level);
    state.attributes.pop_back();
    state.infos.pop_back();
    state.connect_derived();
    throw;
  }
  return id;
}

void Store::add_level(AttributeId attribute) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& data = attribute_of(state, attribute);
  AttributeInfo& info = state.infos[attribute];
  const int level = info.finest_level + 1;
  if (level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add level {} to '{}': the finest possible level is {}", level,
                            info.schema.name, kMaxLevel));
  if (data.derived) {
    state.add_derived_level(attribute);
    return state.connect_derived();
  }
  StoredLevel made;
  made.number = data.record.number;
  made.level = level;
  made.record.pipeline = LevelPipelines::parse(data.record.pipeline).of(level);
  made.record.generation = state.sequence + 1;
  // The file may be a left-over of a run that ended before its commit.
  if (state.on_disk()) state.directory.remove(made.file_name());
  made.geometry = LevelGeometry(state.base.slot_shapes(), relative_to_base(level, base_level()),
                                info.schema.record_bytes(), state.options.block_bytes);
  made.table = BlockTable(state.uuid, made.number, level, made.geometry.block_count());
  const LevelRecord record = made.record;
  data.levels.push_back(state.open_level(std::move(made), info.schema, OpenMode::kCreate));
  data.record.levels.push_back(record);
  info.finest_level = level;
  state.connect_derived();
}

void Store::set_pipeline(AttributeId attribute, std::string pipeline) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& data = attribute_of(state, attribute);
  const AttributeSchema& schema = state.infos[attribute].schema;
  pipeline = state.checked_pipeline(std::move(pipeline), schema);
  if ((data.derived || is_derived(pipeline)) && !data.levels.empty() &&
      pipeline != data.record.pipeline)
    throw Error(ErrorCode::kBadState,
                fmt::format("set the pipeline of '{}': expected an attribute without levels, "
                            "because a derived one has no files; recode_attribute() changes one "
                            "that has levels",
                            schema.name));
  data.record.pipeline = std::move(pipeline);
  state.follow_pipeline(data, schema);
  state.connect_derived();
}

void Store::plan_levels(AttributeId attribute, int finest_level, std::string_view made_as) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& data = attribute_of(state, attribute);
  if (data.derived) return;
  AttributeSchema schema = state.infos[attribute].schema;
  if (!made_as.empty()) schema.name = made_as;
  data.record.pipeline =
      state.backend.plan_pipeline(data.record.pipeline, state.provenance, schema, finest_level);
}

void Store::set_rounding(AttributeId attribute, const std::optional<Rounding>& rounding) {
  Implementation& state = *implementation_;
  check_writable(state);
  auto& record = attribute_of(state, attribute).record;
  if (rounding)
    for (const double length :
         {rounding->bound, rounding->step, rounding->largest_error, rounding->rms_error})
      if (!(length >= 0) || !std::isfinite(length))
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("record the rounding of attribute '{}': expected lengths of 0 or "
                                "more, found {:g}",
                                state.infos[attribute].schema.name, length));
  record.rounding = rounding;
}

void Store::remove_attribute(AttributeId attribute) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& removed = attribute_of(state, attribute);
  check_not_needed_by_others(state, removed, Replaced::kNo);
  for (auto& level : removed.levels) state.pager->detach(*level);
  state.attributes.erase(state.attributes.begin() + attribute);
  state.infos.erase(state.infos.begin() + attribute);
  state.connect_derived();
}

void Store::replace_attribute(AttributeId attribute, AttributeId replacement) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& old = attribute_of(state, attribute);
  attribute_of(state, replacement);
  std::string name = state.infos[attribute].schema.name;
  if (attribute == replacement)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("replace attribute '{}': expected another one in its place", name));
  check_not_needed_by_others(state, old, Replaced::kYes);
  for (auto& level : old.levels) state.pager->detach(*level);
  state.attributes[attribute] = std::move(state.attributes[replacement]);
  state.infos[attribute] = state.infos[replacement];
  state.infos[attribute].schema.name = std::move(name);
  state.attributes.erase(state.attributes.begin() + replacement);
  state.infos.erase(state.infos.begin() + replacement);
  state.connect_derived();
}

PLAIT_END_NAMESPACE
