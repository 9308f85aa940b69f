// The functions of a store: attributes, levels, commits.
#include "plait/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "plait/edge_index.h"
#include "plait/error.h"
#include "store/file_names.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void check_writable(const Store::Implementation& state) {
  if (!state.writable)
    throw Error(ErrorCode::kBadState, fmt::format("{}: opened for reading", state.path.native()));
}

/// Errors: kInvalidArgument for a number that is no attribute's.
template <class State>
auto& attribute_of(State& state, AttributeId attribute) {
  if (attribute >= state.attributes.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected an attribute below {}, found {}", state.path.native(),
                            state.attributes.size(), attribute));
  return state.attributes[attribute];
}

/// Errors: kInvalidArgument for an attribute or a level that is not there.
template <class State>
auto& level_of(State& state, AttributeId attribute, int level) {
  auto& data = attribute_of(state, attribute);
  const int first = state.options.base_level + 1, last = state.infos[attribute].finest_level;
  if (level < first || level > last)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("level {} of '{}': expected {} to {}", level,
                            state.infos[attribute].schema.name, first, last));
  return *data.levels[static_cast<std::size_t>(level - first)];
}

/// Errors: kBadState if a written block of another attribute was encoded from `needed`.
void check_not_needed_by_others(const Store::Implementation& state,
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
                                  state.path.native(), level->path.native()));
    }
  }
}

}  // namespace

Store::Store(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

const std::filesystem::path& Store::path() const { return implementation_->path; }
const BaseMesh& Store::base() const { return implementation_->base; }
const StoreOptions& Store::options() const { return implementation_->options; }
const StoreUuid& Store::uuid() const { return implementation_->uuid; }
std::uint64_t Store::sequence() const { return implementation_->sequence; }
BackendTraits Store::backend_traits() const { return implementation_->backend.traits; }
int Store::base_level() const { return implementation_->options.base_level; }
const Provenance& Store::provenance() const { return implementation_->provenance; }

void Store::set_provenance(const Provenance& provenance) {
  Implementation& state = *implementation_;
  if (provenance.layout != state.options.layout ||
      provenance.base_level != state.options.base_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("record the provenance of a store: expected layout '{}' and base level "
                            "{}, found '{}' and {}",
                            state.options.layout, state.options.base_level, provenance.layout,
                            provenance.base_level));
  const Provenance former = std::exchange(state.provenance, provenance);
  try {
    encode_description(state.description());  // refuses text that a version cannot record
  } catch (...) {
    state.provenance = former;
    throw;
  }
}
Session Store::open_session(const SessionOptions& options) const {
  return implementation_->pager->open_session(options);
}
Pager& Store::pager() { return *implementation_->pager; }
const Pager& Store::pager() const { return *implementation_->pager; }
PagingStatistics Store::statistics() const { return implementation_->pager->statistics(); }
std::span<const AttributeInfo> Store::attributes() const { return implementation_->infos; }

int Store::finest_level() const {
  int finest = base_level();
  for (const AttributeInfo& info : attributes()) finest = std::max(finest, info.finest_level);
  return finest;
}

bool Store::has_attribute(std::string_view name) const {
  return std::ranges::any_of(attributes(),
                             [&](const AttributeInfo& info) { return info.schema.name == name; });
}

AttributeId Store::attribute(std::string_view name) const {
  std::string known;
  for (AttributeId id = 0; id < attributes().size(); ++id) {
    if (attributes()[id].schema.name == name) return id;
    known += (known.empty() ? "" : ", ") + attributes()[id].schema.name;
  }
  throw Error(ErrorCode::kNotFound,
              fmt::format("{}: no attribute '{}'; there are: {}", path().native(), name,
                          known.empty() ? "none" : known));
}

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
  state.backend.validate_pipeline(pipeline, schema);
  Implementation::Attribute attribute;
  attribute.record.number = state.next_number++;
  attribute.record.pipeline = std::move(pipeline);
  attribute.base_bytes.resize(state.base.vertex_count() * schema.record_bytes());
  state.attributes.push_back(std::move(attribute));
  state.infos.push_back({std::move(schema), base_level()});
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
  StoredLevel made;
  made.number = data.record.number;
  made.level = level;
  made.record.pipeline = data.record.pipeline;
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
}

void Store::set_pipeline(AttributeId attribute, std::string pipeline) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& data = attribute_of(state, attribute);
  state.backend.validate_pipeline(pipeline, state.infos[attribute].schema);
  data.record.pipeline = std::move(pipeline);
}

void Store::plan_levels(AttributeId attribute, int finest_level, std::string_view made_as) {
  Implementation& state = *implementation_;
  check_writable(state);
  Implementation::Attribute& data = attribute_of(state, attribute);
  AttributeSchema schema = state.infos[attribute].schema;
  if (!made_as.empty()) schema.name = made_as;
  data.record.pipeline =
      state.backend.plan_pipeline(data.record.pipeline, state.provenance, schema, finest_level);
}

const std::optional<Rounding>& Store::rounding(AttributeId attribute) const {
  return attribute_of(*implementation_, attribute).record.rounding;
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
  check_not_needed_by_others(state, removed);
  for (auto& level : removed.levels) state.pager->detach(*level);
  state.attributes.erase(state.attributes.begin() + attribute);
  state.infos.erase(state.infos.begin() + attribute);
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
  check_not_needed_by_others(state, old);
  for (auto& level : old.levels) state.pager->detach(*level);
  state.attributes[attribute] = std::move(state.attributes[replacement]);
  state.infos[attribute] = state.infos[replacement];
  state.infos[attribute].schema.name = std::move(name);
  state.attributes.erase(state.attributes.begin() + replacement);
  state.infos.erase(state.infos.begin() + replacement);
}

std::span<std::byte> Store::base_bytes(AttributeId attribute) {
  if (!implementation_->writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("change base records of {}: opened for reading; a const Store gives "
                            "records to read",
                            path().native()));
  auto& data = attribute_of(*implementation_, attribute);
  for (const auto& level : data.levels)
    if (level->backend->needs_base_records() &&
        std::ranges::any_of(level->table.entries(), [](const BlockEntry& entry) {
          return entry.encoding == BlockEncoding::kEncoded;
        }))
      throw Error(ErrorCode::kBadState,
                  fmt::format("change base records of '{}' in {}: expected no blocks that are "
                              "encoded from these records, found some in {}; a const Store gives "
                              "records to read",
                              implementation_->infos[attribute].schema.name, path().native(),
                              level->path.native()));
  return data.base_bytes;
}

std::span<const std::byte> Store::base_bytes(AttributeId attribute) const {
  return attribute_of(*implementation_, attribute).base_bytes;
}

const LevelFile& Store::level_file(AttributeId attribute, int level) const {
  return level_of(*implementation_, attribute, level);
}

LevelFile& Store::level_file(AttributeId attribute, int level) {
  return level_of(*implementation_, attribute, level);
}

void Store::check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const {
  attribute_of(*implementation_, attribute);
  const AttributeSchema& schema = attributes()[attribute].schema;
  if (schema.type != type || schema.components != components)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("attribute '{}' has {} x {} records, but the caller expects {} x {}",
                            schema.name, to_string(schema.type), schema.components, to_string(type),
                            components));
}

void Store::commit() {
  for (AttributeId id = 0; id < attributes().size(); ++id)
    for (int level = base_level() + 1; level <= attributes()[id].finest_level; ++level)
      if (!level_file(id, level).is_finished())
        throw Error(ErrorCode::kBadState,
                    fmt::format("commit {}: level {} of '{}' is unfinished: a pass that writes to "
                                "it was cancelled, failed or has not ended",
                                path().native(), level, attributes()[id].schema.name));
  if (!implementation_->writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: opened for reading", path().native()));
  if (implementation_->failed)
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: refused because an earlier commit failed; reopen the store",
                            path().native()));
  try {
    implementation_->pager->flush();
    if (implementation_->on_disk())
      implementation_->write_version();
    else
      ++implementation_->sequence;
  } catch (...) {
    // The new manifest slot may be on the disk or not. From here on, an overwritten block could
    // belong to either version, but the journal can only restore the older one. So the store
    // refuses further writes.
    implementation_->failed = true;
    implementation_->pager->refuse_writes();
    throw;
  }
}

void Store::close() {
  if (!implementation_) return;
  if (const auto readers = implementation_.use_count() - 1; readers > 0)
    throw Error(ErrorCode::kBusy,
                fmt::format("close {}: expected no reader of this store, found {} with {} open "
                            "views",
                            path().native(), readers, implementation_->view_count.load()));
  implementation_.reset();
}

std::uint64_t Store::stored_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& attribute : implementation_->attributes) {
    bytes += attribute.base_bytes.size();
    for (const auto& level : attribute.levels) bytes += level->backend->stored_bytes();
  }
  return bytes + implementation_->base_mesh_size.bytes;
}

PLAIT_END_NAMESPACE
