// Derived attributes of a store: pipelines, levels, and the connection to their sources.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/base_relative_level.h"
#include "plait/error.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string Store::Implementation::checked_pipeline(std::string pipeline,
                                                    const AttributeSchema& schema) const {
  if (!is_derived(pipeline)) {
    backend.validate_pipeline(pipeline, schema);
    return pipeline;
  }
  if (!derivations)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("derive '{}': expected a registry of backends with rules "
                            "(BackendRegistry::set_derivations), found none",
                            schema.name));
  std::string derivation(derivation_in(pipeline));
  if (derivation.empty()) derivation = derivations->usual(schema);
  derivations->source_of(derivation, schema);
  return derived_pipeline(derivation);
}

void Store::Implementation::follow_pipeline(Attribute& attribute,
                                            const AttributeSchema& schema) const {
  const std::string_view derivation = derivation_in(attribute.record.pipeline);
  if (derivation.empty()) {
    attribute.derived.reset();
    attribute.base_bytes.resize(base.vertex_count() * schema.record_bytes());
    return;
  }
  attribute.base_bytes.clear();
  attribute.derived =
      std::make_unique<DerivedAttribute>(derivations, std::string(derivation), schema);
}

AttributeId Store::Implementation::source_of(const Attribute& derived) const {
  for (AttributeId id = 0; id < infos.size(); ++id)
    if (infos[id].schema.name == derived.derived->source()) return id;
  return kNoId;
}

std::unique_ptr<LevelFile> Store::Implementation::open_derived_level(const Attribute& attribute,
                                                                     const AttributeSchema& schema,
                                                                     int level, int finest) const {
  auto file = std::make_unique<LevelFile>();
  file->geometry =
      derived_geometry(base.slot_shapes(), relative_to_base(level, options.base_level).refinements,
                       relative_to_base(finest, options.base_level).refinements,
                       schema.record_bytes(), options.block_bytes);
  file->table = BlockTable(uuid, attribute.record.number, level, file->geometry.block_count());
  for (BlockEntry& entry : file->table.entries()) entry.encoding = BlockEncoding::kPredicted;
  file->path = fmt::format("{}: level {} of '{}'", path.native(), level, schema.name);
  file->traits.durable = backend.traits.durable;
  file->pipeline = attribute.record.pipeline;
  file->writable = writable;
  file->is_derived = true;
  file->backend = attribute.derived->open_level(file->geometry, file->path.native());
  pager->attach(*file);
  return file;
}

void Store::Implementation::add_derived_level(AttributeId attribute) {
  Attribute& data = attributes[attribute];
  AttributeInfo& info = infos[attribute];
  const int level = info.finest_level + 1;
  const AttributeId source = source_of(data);
  const int finest = source == kNoId ? options.base_level : infos[source].finest_level;
  if (level > finest)
    throw Error(ErrorCode::kBadState,
                fmt::format("add level {} to '{}': it is computed from '{}', expected that "
                            "attribute to have the level, found {}",
                            level, info.schema.name, data.derived->source(),
                            source == kNoId ? "no such attribute" : fmt::format("{}", finest)));
  LevelRecord record;
  record.pipeline = data.record.pipeline;
  record.generation = sequence + 1;
  data.levels.push_back(open_derived_level(data, info.schema, level, finest));
  data.record.levels.push_back(std::move(record));
  info.finest_level = level;
}

void Store::Implementation::connect_derived() {
  std::uint64_t scratch_bytes = volume->scratch_bytes();
  for (AttributeId id = 0; id < attributes.size(); ++id) {
    Attribute& attribute = attributes[id];
    if (!attribute.derived) continue;
    for (auto& level : attribute.levels) {
      level->made_from.clear();
      ++level->changes;
    }
    const AttributeId source_id = source_of(attribute);
    const std::string& name = attribute.derived->source();
    if (source_id == kNoId) {
      attribute.derived->disconnect(
          fmt::format("it is computed from '{}', which the store does not have", name));
      continue;
    }
    const Attribute& from = attributes[source_id];
    if (from.derived || from.levels.size() != attribute.levels.size()) {
      attribute.derived->disconnect(
          from.derived
              ? fmt::format("it is computed from '{}', expected a stored attribute", name)
              : fmt::format("it has level {}, expected the finest level of '{}', which is {}",
                            infos[id].finest_level, name, infos[source_id].finest_level));
      continue;
    }
    DerivationSource source{
        base.topology(), infos[source_id].schema, from.base_bytes, {}, pager.get()};
    for (const auto& level : from.levels) source.levels.push_back(level.get());
    for (auto& level : attribute.levels) level->made_from = source.levels;
    try {
      attribute.derived->connect(std::move(source));
      scratch_bytes += attribute.derived->scratch_bytes();
    } catch (const Error& error) {  // the source has other records than the rule reads
      attribute.derived->disconnect(error.what());
    }
  }
  pager->set_aside(
      std::min(scratch_bytes, std::max(volume->scratch_bytes(), options.budget_bytes / 2)));
}

void Store::Implementation::base_changed(AttributeId attribute) {
  for (const auto& level : attributes[attribute].levels) ++level->changes;
  for (Attribute& other : attributes)
    if (other.derived && source_of(other) == attribute) other.derived->source_base_changed();
}

PLAIT_END_NAMESPACE
