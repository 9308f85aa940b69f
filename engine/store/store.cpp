// The functions of a store: what it has, the records and levels of its attributes, commits.
#include "plait/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"
#include "store/store_checks.h"
#include "store/store_state.h"
#include "store/version_description.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

std::string_view Store::derivation(AttributeId attribute) const {
  const auto& data = attribute_of(*implementation_, attribute);
  return data.derived ? std::string_view(data.derived->derivation()) : std::string_view();
}

const std::optional<Rounding>& Store::rounding(AttributeId attribute) const {
  return attribute_of(*implementation_, attribute).record.rounding;
}

std::span<std::byte> Store::base_bytes(AttributeId attribute) {
  if (!implementation_->writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("change base records of {}: opened for reading; a const Store gives "
                            "records to read",
                            path().native()));
  auto& data = attribute_of(*implementation_, attribute);
  if (data.derived)
    throw Error(ErrorCode::kBadState,
                fmt::format("change base records of '{}' in {}: expected an attribute that is "
                            "stored, found one that is computed from '{}'; change that one, or "
                            "store '{}' first (plait convert --compress {}=stored)",
                            implementation_->infos[attribute].schema.name, path().native(),
                            data.derived->source(), implementation_->infos[attribute].schema.name,
                            implementation_->infos[attribute].schema.name));
  implementation_->base_changed(attribute);
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
  const auto& data = attribute_of(*implementation_, attribute);
  return data.derived ? data.derived->base_records() : std::span<const std::byte>(data.base_bytes);
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
  for (const auto& attribute : implementation_->attributes)
    if (attribute.derived && !attribute.derived->refusal().empty())
      throw Error(ErrorCode::kBadState,
                  fmt::format("commit {}: a derived attribute cannot be computed: {}",
                              path().native(), attribute.derived->refusal()));
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
