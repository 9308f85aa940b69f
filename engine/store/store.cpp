// The functions of a store: what it has, the records and levels of its attributes, commits.
#include "plait/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "format/change_record.h"
#include "format/checksum.h"
#include "format/version_description.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/store_info.h"
#include "store/memory_snapshot.h"
#include "store/store_checks.h"
#include "store/store_state.h"
#include "store/store_uuid.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Store::Store(std::unique_ptr<Implementation> implementation)
    : implementation_(Implementation::own(std::move(implementation))) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

const std::filesystem::path& Store::path() const { return state().path; }
const BaseMesh& Store::base() const { return state().base; }
const StoreOptions& Store::options() const { return state().options; }
std::uint64_t Store::sequence() const { return state().sequence; }
int Store::base_level() const { return state().provenance.base_level; }
const Provenance& Store::provenance() const { return state().provenance; }

void set_uuid(Store& store, const StoreUuid& uuid) {
  Store::Implementation& state = StoreAccess::state(store);
  if (state.sequence != 0 || !state.attributes.empty())
    throw Error(ErrorCode::kBadState, "set the UUID of a store: it has one already");
  state.uuid = uuid;
}

void StoreAccess::set_provenance(Store& store, const Provenance& provenance) {
  Store::Implementation& state = store.state();
  begin_change(state, Change::kAdd, "set the provenance of");
  const Provenance former = state.provenance;
  state.provenance = provenance;
  state.provenance.layout = former.layout;
  state.provenance.base_level = former.base_level;
  try {
    encode_description(state.description());  // refuses text that a version cannot record
  } catch (...) {
    state.provenance = former;
    throw;
  }
}
Session StoreAccess::open_session(const Store& store, const SessionOptions& options) {
  return store.state().pager->open_session(options);
}
Pager& StoreAccess::pager(Store& store) { return *store.state().pager; }
const Pager& StoreAccess::pager(const Store& store) { return *store.state().pager; }
const BackendTraits& StoreAccess::backend_traits(const Store& store) {
  return store.state().backend.traits;
}
std::span<const AttributeInfo> Store::attributes() const { return state().infos; }

int Store::finest_level() const {
  int finest = base_level();
  for (const AttributeInfo& info : attributes()) finest = std::max(finest, info.finest_level);
  return finest;
}

bool Store::has_depths() const { return base().depths() != nullptr; }

int Store::depth(FaceId face) const {
  if (face >= base().face_count())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("depth of face {} of {}: expected a face below {}", face,
                            state().name(), base().face_count()));
  const FaceDepths* const depths = base().depths();
  return depths == nullptr ? finest_level()
                           : std::min(finest_level(), base_level() + depths->of(face));
}

void StoreAccess::refuse_depths(const Store& store, std::string_view verb, int level) {
  const FaceDepths* const depths = store.base().depths();
  if (depths == nullptr || level <= store.base_level() + depths->shallowest()) return;
  throw Error(
      ErrorCode::kNotSupported,
      fmt::format("{} {}: level {} needs all faces, and the faces have depths of their own, "
                  "{} to {}: take the store that it was pruned from, level {}, or a copy by plait "
                  "convert --depth uniform",
                  verb, store.state().name(), level, store.base_level() + depths->shallowest(),
                  store.base_level() + depths->deepest(),
                  store.base_level() + depths->shallowest()))
      .about(store.path());
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
              fmt::format("{}: no attribute '{}'; there are: {}", state().name(), name,
                          known.empty() ? "none" : known))
      .about(path());
}

const std::optional<Rounding>& StoreAccess::rounding(const Store& store, AttributeId attribute) {
  return attribute_of(store.state(), attribute).record.rounding;
}

std::span<std::byte> Store::base_bytes(AttributeId attribute) {
  const std::span<std::byte> bytes = StoreAccess::base_bytes(*this, attribute, Access::kUpdate);
  StoreAccess::lend_base_records(*this, attribute);
  return bytes;
}

void StoreAccess::lend_base_records(Store& store, AttributeId attribute) {
  attribute_of(store.state(), attribute).base_changes.are_lent = true;
}

std::span<std::byte> StoreAccess::base_bytes(Store& store, AttributeId attribute, Access access) {
  begin_base_change(store, attribute, access);
  return attribute_of(store.state(), attribute).base_bytes;
}

void StoreAccess::put_base_records(Store& store, AttributeId attribute,
                                   std::span<const VertexId> vertices,
                                   std::span<const std::byte> records) {
  attribute_of(store.state(), attribute).base_bytes.put(vertices, records);
}

void StoreAccess::read_base_records(const Store& store, AttributeId attribute, std::uint64_t first,
                                    std::span<std::byte> into) {
  check_readable(store, attribute, store.base_level(), true);
  attribute_of(store.state(), attribute).base_bytes.read(first, into);
}

void StoreAccess::begin_base_change(Store& store, AttributeId attribute, Access access) {
  Store::Implementation& state = store.state();
  begin_change(state, Change::kRecords,
               "change base records (a const Store gives them to read) of");
  auto& data = attribute_of(state, attribute);
  if (access != Access::kOverwrite) check_readable(store, attribute, store.base_level(), true);
  // A block on its way to the disk may be encoded from these records right now.
  state.pager->wait_for_writes();
  for (const auto& other : state.attributes)
    for (const auto& level : other.levels)
      if (level->backend->needs_base_records(data.record.number))
        throw Error(
            ErrorCode::kBadState,
            fmt::format("change base records of '{}' in {}: expected no blocks that are "
                        "encoded from these records, found some in {}; a const Store gives "
                        "records to read",
                        state.infos[attribute].schema.name, state.name(), level->path.native()));
  data.base_changes.may_have_some = true;
}

std::span<const std::byte> Store::base_bytes(AttributeId attribute) const {
  StoreAccess::check_readable(*this, attribute, base_level(), true);
  return attribute_of(state(), attribute).base_bytes;
}

const LevelFile& StoreAccess::level_file(const Store& store, AttributeId attribute, int level) {
  return level_of(store.state(), attribute, level);
}

LevelFile& StoreAccess::level_file(Store& store, AttributeId attribute, int level) {
  return level_of(store.state(), attribute, level);
}

LevelGeometry StoreAccess::geometry(const Store& store, std::size_t record_bytes, int level,
                                    std::uint64_t block_bytes) {
  const Store::Implementation& state = store.state();
  const LevelGeometry whole = state.whole_geometry(record_bytes, level, block_bytes);
  return state.is_part() ? whole.shard(state.only_shard) : whole;
}

LevelGeometry Store::Implementation::whole_geometry(std::size_t record_bytes, int level,
                                                    std::uint64_t block_bytes) const {
  return base
      .geometry(relative_to_base(level, provenance.base_level), record_bytes,
                block_bytes != 0 ? block_bytes : options.block_bytes)
      .in_shards(shards);
}

void Store::check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const {
  attribute_of(state(), attribute);
  const AttributeSchema& schema = attributes()[attribute].schema;
  if (schema.type != type || schema.components != components)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("attribute '{}' has {} x {} records, but the caller expects {} x {}",
                            schema.name, to_string(schema.type), schema.components, to_string(type),
                            components));
}

void StoreAccess::check_type(const Store& store, AttributeId attribute, ComponentType type,
                             std::uint32_t components) {
  store.check_type(attribute, type, components);
}

void Store::Implementation::find_changed_records() {
  for (Attribute& attribute : attributes)
    if (attribute.base_changes.must_be_looked_for())
      attribute.piece_checksums_now = attribute.base_bytes.piece_checksums();
  for (FaceAttribute& attribute : face_attributes)
    if (attribute.changes.must_be_looked_for())
      attribute.checksum_now = checksum_of(attribute.bytes);
}

bool Store::Implementation::has_changes() const {
  if (changed || sequence == 0 || pager->statistics().blocks_written != blocks_at_commit)
    return true;
  return std::ranges::any_of(attributes,
                             [](const Attribute& attribute) {
                               return attribute.piece_checksums_now != attribute.piece_checksums;
                             }) ||
         std::ranges::any_of(face_attributes, [](const FaceAttribute& attribute) {
           return attribute.checksum_now != attribute.checksum;
         });
}

void Store::Implementation::note_committed() {
  changed = false;
  blocks_at_commit = pager->statistics().blocks_written;
  for (Attribute& attribute : attributes) {
    if (attribute.base_changes.must_be_looked_for())
      attribute.piece_checksums = attribute.piece_checksums_now;
    attribute.base_changes.may_have_some = false;
  }
  for (FaceAttribute& attribute : face_attributes) {
    attribute.checksum = attribute.checksum_now;
    attribute.changes.may_have_some = false;
  }
}

void Store::commit() try {
  const Stopwatch watch;
  Implementation& state = this->state();
  check_change(state, Change::kCommit, "commit");
  if (state.is_part())
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: it is a part of a store: join all parts", state.name()));
  for (AttributeId id = 0; id < attributes().size(); ++id) {
    for (int level = base_level(); level <= attributes()[id].finest_level; ++level)
      if (const WrittenRecords& records = written_records_of(state, id, level);
          !records.is_finished())
        throw Error(ErrorCode::kBadState,
                    fmt::format("commit {}: level {} of '{}' is unfinished: {}; run a pass again "
                                "that overwrites it, or take Store::roll_back()",
                                state.name(), level, attributes()[id].schema.name,
                                why_unfinished(records)));
    if (!state.attributes[id].becomes.empty())
      throw Error(ErrorCode::kBadState,
                  fmt::format("commit {}: the work that makes '{}' has not ended; take "
                              "Store::roll_back()",
                              state.name(), attributes()[id].schema.name));
  }
  if (state.failed)
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: refused because an earlier commit failed; reopen the store",
                            state.name()));
  finish_encoding();
  try {
    state.pager->flush();
    state.find_changed_records();
    if (!state.has_changes()) return;
    if (state.on_disk())
      state.write_version();
    else {
      auto snapshot = std::make_shared<MemorySnapshot>(state);
      ++state.sequence;
      state.snapshot = std::move(snapshot);
    }
    state.note_committed();
  } catch (...) {
    // The new manifest slot may be on the disk or not, so no block of either version may change.
    state.failed = true;
    state.pager->refuse_writes();
    throw;
  }
  state.tell(StoreEvent::Kind::kCommitted, watch);
} catch (const std::bad_alloc&) {
  throw out_of_memory("commit " + state().name());
}

void Store::close() {
  if (!implementation_) return;
  check_undisturbed(state(), Change::kRemove, "close");
  implementation_.reset();
}

StoreInfo Store::info() const try {
  const Implementation& state = this->state();
  StoreInfo info{
      state.uuid, state.backend.traits, state.pager->statistics(), state.base_mesh_size.bytes, {}};
  for (const auto& attribute : state.attributes) {
    info.stored_bytes += attribute.base_bytes.size();
    for (const auto& level : attribute.levels) info.stored_bytes += level->backend->stored_bytes();
    info.roundings.push_back(attribute.record.rounding);
  }
  for (const auto& attribute : state.face_attributes) info.stored_bytes += attribute.bytes.size();
  return info;
} catch (const std::bad_alloc&) {
  throw out_of_memory("read figures of " + state().name());
}

PLAIT_END_NAMESPACE
