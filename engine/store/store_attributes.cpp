// The functions of a store that add, change and remove attributes and levels.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "format/version_description.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The attribute that Provenance::scheme refines.
constexpr std::string_view kSubdivided = "position";

void check_not_needed(const Store::Implementation& state,
                      const Store::Implementation::Attribute& needed) {
  for (const auto& other : state.attributes) {
    if (&other == &needed) continue;
    for (const auto& level : other.levels) {
      std::array<ContextBlock, kMostContextBlocks> blocks;
      const std::size_t count = level->backend->context(0, blocks);
      for (const ContextBlock& block : std::span(blocks).first(count))
        if (block.attribute == needed.record.number)
          throw Error(ErrorCode::kBadState,
                      fmt::format("remove an attribute of {}: {} is encoded from its levels",
                                  state.name(), level->path.native()));
    }
  }
}

namespace {

AttributeId add(Store::Implementation& state, AttributeSchema schema, bool is_replacement) try {
  begin_change(state, Change::kAdd, "add an attribute to");
  if (!is_attribute_name(schema.name) || schema.record_bytes() == 0 || schema.components > 255)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': expected a name of 1 to {} characters of "
                            "[A-Za-z0-9_-] and 1 to 255 components",
                            schema.name, kMaxAttributeNameBytes));
  const std::string name =
      is_replacement ? StoreAccess::name_until_named(schema.name) : schema.name;
  const auto has_name = [&](const AttributeInfo& info) { return info.schema.name == name; };
  if (std::ranges::any_of(state.infos, has_name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': the name is taken", name));
  if (state.infos.size() >= kMaxAttributes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': expected fewer than {} attributes, found {}",
                            schema.name, kMaxAttributes, state.infos.size()));
  if (state.next_number == std::numeric_limits<std::uint32_t>::max())
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("add attribute '{}': the store has used all attribute numbers", schema.name));
  LevelPipelines pipeline =
      state.options.pipeline_of ? state.options.pipeline_of(schema) : *state.options.pipeline;
  state.backend.check_pipelines(pipeline, schema);
  Store::Implementation::Attribute attribute;
  attribute.record.number = state.next_number++;
  attribute.record.pipeline = std::move(pipeline);
  const std::uint64_t base_bytes = state.base.vertex_count() * schema.record_bytes();
  if (state.base.piece_bytes() != 0 && state.on_disk())
    attribute.base_bytes = state.base_records_in_file(attribute.record.number, base_bytes);
  else
    attribute.base_bytes = ZeroedArray<std::byte>(base_bytes);
  if (is_replacement) attribute.becomes = std::exchange(schema.name, name);
  state.attributes.push_back(std::move(attribute));
  state.infos.push_back({std::move(schema), state.provenance.base_level});
  return static_cast<AttributeId>(state.infos.size() - 1);
} catch (const std::bad_alloc&) {
  throw out_of_memory("add an attribute to " + state.name());
}

/// A level of a store with depths has a slot, and no blocks that are made.
void check_depths_have(const Store::Implementation& state, int level, const AttributeSchema& schema,
                       const Pipeline& pipeline) {
  const FaceDepths* const depths = state.base.depths();
  if (depths == nullptr) return;
  const int deepest = state.provenance.base_level + depths->deepest();
  if (level > deepest)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add level {} to '{}': no face of {} is deeper than level {}", level,
                            schema.name, state.name(), deepest));
  check_pipeline_of_depths(state, schema, pipeline);
}

}  // namespace

void check_pipeline_of_depths(const Store::Implementation& state, const AttributeSchema& schema,
                              const Pipeline& pipeline) {
  if (state.base.depths() == nullptr) return;
  if (!pipeline.recipe || pipeline.recipe->empty()) return;
  throw Error(ErrorCode::kNotSupported,
              fmt::format("compress '{}' of {} by \"{}\": it makes all blocks of all faces, and "
                          "faces have depths of their own: take a pipeline that stores them, as "
                          "--compress default",
                          schema.name, state.name(), pipeline.to_text()));
}

AttributeId Store::add_attribute(AttributeSchema schema) {
  return add(state(), std::move(schema), false);
}

AttributeId StoreAccess::add_replacement(Store& store, AttributeSchema schema) {
  return add(store.state(), std::move(schema), true);
}

AttributeId Store::add_attribute(AttributeSchema schema, int finest_level) {
  Implementation& state = this->state();
  if (finest_level < base_level() || finest_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}' with levels up to {}: expected {} to {}",
                            schema.name, finest_level, base_level(), kMaxLevel));
  const AttributeId id = add_attribute(std::move(schema));
  try {
    while (state.infos[id].finest_level < finest_level) add_level(id);
  } catch (...) {
    state.retire(std::move(state.attributes[id].levels));
    state.attributes.pop_back();
    state.infos.pop_back();
    throw;
  }
  return id;
}

void Store::add_level(AttributeId attribute) { add_level(attribute, false); }

void Store::add_level(AttributeId attribute, bool is_final) try {
  Implementation& state = this->state();
  begin_change(state, Change::kAdd, "add a level to");
  Implementation::Attribute& data = attribute_of(state, attribute);
  AttributeInfo& info = state.infos[attribute];
  const int level = info.finest_level + 1;
  if (level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add level {} to '{}': the finest possible level is {}", level,
                            info.schema.name, kMaxLevel));
  const Pipeline& wanted = data.named_pipelines().of(level);
  check_depths_have(state, level, info.schema, wanted);
  StoredLevel made;
  made.number = data.record.number;
  made.level = level;
  const AttributeSchema schema = state.final_schema(attribute);
  const Pipeline &last = data.named_pipelines().of(level),
                 &planned = data.record.pipeline.of(level);
  made.record.pipeline = is_final ? planned : state.backend.first_pipeline(last, planned, schema);
  const bool waits = !is_final && state.backend.needs_other_blocks(last, schema);
  made.record.generation = state.sequence + 1;
  // The file may be a left-over of a run that ended before its commit.
  if (state.on_disk() && !state.is_part()) state.directory.remove(made.file_names().front());
  made.geometry = state.whole_geometry(
      info.schema.record_bytes(), level,
      block_bytes_of_level(made.record.pipeline, level - base_level(), state.options.block_bytes));
  std::uint64_t first_number = 0;
  if (state.is_part()) {
    first_number = made.geometry.first_block(state.only_shard);
    made.geometry = made.geometry.shard(state.only_shard);
  }
  made.table =
      BlockTable(state.uuid, made.number, level, made.geometry.block_count(), first_number);
  made.table.set_generation(made.record.generation);
  const LevelRecord record = made.record;
  data.levels.push_back(state.open_level(std::move(made), schema, OpenMode::kCreate));
  data.record.levels.push_back(record);
  if (waits) data.last_pipelines.emplace(level, last);
  info.finest_level = level;
} catch (const std::bad_alloc&) {
  throw out_of_memory("add a level to " + state().name());
}

void Store::set_pipeline(AttributeId attribute, LevelPipelines pipeline) {
  Implementation& state = this->state();
  begin_change(state, Change::kAdd, "set a pipeline of");
  Implementation::Attribute& data = attribute_of(state, attribute);
  const AttributeSchema& schema = state.infos[attribute].schema;
  state.backend.check_pipelines(pipeline, schema);
  data.record.pipeline = std::move(pipeline);
  data.unplanned.reset();
}

void StoreAccess::plan_levels(Store& store, AttributeId attribute, int finest_level,
                              bool others_are_complete) {
  Store::Implementation& state = store.state();
  begin_change(state, Change::kAdd, "plan levels of");
  Store::Implementation::Attribute& data = attribute_of(state, attribute);
  if (state.base.depths() != nullptr)  // a recipe is that of the store that was copied
    data.record.pipeline.for_each([](Pipeline& pipeline) {
      if (pipeline.recipe) pipeline = pipeline.with_recipe({});
    });
  data.unplanned = data.record.pipeline;
  PlannedLevels levels{state.final_schema(attribute), state.provenance, finest_level,
                       others_are_complete};
  if (state.base.depths() != nullptr) {  // no maker knows slots of such faces
    levels.provenance = {.base_level = state.provenance.base_level};
    levels.others_are_complete = false;
  }
  data.record.pipeline = state.backend.planned(*data.unplanned, levels);
}

AttributeSchema Store::Implementation::final_schema(AttributeId attribute) const {
  AttributeSchema schema = infos[attribute].schema;
  if (const std::string& name = attributes[attribute].becomes; !name.empty()) schema.name = name;
  return schema;
}

void StoreAccess::set_rounding(Store& store, AttributeId attribute,
                               const std::optional<Rounding>& rounding) {
  Store::Implementation& state = store.state();
  begin_change(state, Change::kAdd, "record a rounding in");
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
  Implementation& state = this->state();
  begin_change(state, Change::kRemove, "remove an attribute of");
  Implementation::Attribute& removed = attribute_of(state, attribute);
  check_not_needed(state, removed);
  state.retire(std::move(removed.levels));
  state.attributes.erase(state.attributes.begin() + attribute);
  state.infos.erase(state.infos.begin() + attribute);
}

void Store::replace_attribute(AttributeId attribute, AttributeId replacement) {
  Implementation& state = this->state();
  begin_change(state, Change::kRemove, "replace an attribute of");
  Implementation::Attribute& old = attribute_of(state, attribute);
  attribute_of(state, replacement);
  std::string name = state.infos[attribute].schema.name;
  if (attribute == replacement)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("replace attribute '{}': expected another one in its place", name));
  const AttributeSchema &from = state.infos[attribute].schema,
                        &to = state.infos[replacement].schema;
  if (name == kSubdivided && !state.provenance.scheme.empty() &&
      (from.type != to.type || from.components != to.components))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("replace attribute '{}': scheme {} has made it with {} x {}, expected "
                            "the same of the attribute in its place, found {} x {}",
                            name, state.provenance.scheme, to_string(from.type), from.components,
                            to_string(to.type), to.components));
  check_not_needed(state, old);
  state.retire(std::move(old.levels));
  state.attributes[attribute] = std::move(state.attributes[replacement]);
  state.attributes[attribute].becomes.clear();
  state.infos[attribute] = state.infos[replacement];
  state.infos[attribute].schema.name = std::move(name);
  state.attributes.erase(state.attributes.begin() + replacement);
  state.infos.erase(state.infos.begin() + replacement);
}

std::string StoreAccess::name_until_named(std::string_view name) {
  return fmt::format("{} (new)", name);
}

void StoreAccess::name_replacement(Store& store, AttributeId replacement) {
  Store::Implementation& state = store.state();
  std::string& name = attribute_of(state, replacement).becomes;
  if (store.has_attribute(name)) return store.replace_attribute(store.attribute(name), replacement);
  begin_change(state, Change::kAdd, "name an attribute of");
  state.infos[replacement].schema.name = std::exchange(name, {});
}

PLAIT_END_NAMESPACE
