#include "plait/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <random>
#include <system_error>
#include <thread>

#include "plait/edge_index.h"
#include "plait/error.h"
#include "store/file_names.h"
#include "store/guarded_backend.h"
#include "store/recovery.h"
#include "store/store_state.h"

namespace plait {
namespace {

StoreUuid random_uuid() {
  std::random_device device;
  StoreUuid uuid;
  for (std::byte& byte : uuid) byte = static_cast<std::byte>(device() & 0xff);
  return uuid;
}

void check_options(const StoreOptions& options) {
  if (!std::has_single_bit(options.block_bytes) || options.block_bytes < 4096 ||
      options.block_bytes > (1u << 30))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("create store: block size {}, expected a power of two from 4096 to 2^30",
                    options.block_bytes));
  if (options.base_level < 0 || options.base_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create store: base level {}, expected 0 to {}", options.base_level,
                            kMaxLevel));
}

void check_writable(const Store::Implementation& state) {
  if (!state.writable)
    throw Error(ErrorCode::kBadState, fmt::format("{}: opened for reading", state.path.native()));
}

void check_resources(std::uint64_t budget_bytes, std::optional<int> io_threads) {
  if (io_threads && (*io_threads < 0 || *io_threads > 64))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("open store: {} I/O threads, expected 0 to 64", *io_threads));
  if (budget_bytes < (64u << 10))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("open store: budget {} bytes, expected at least 65536", budget_bytes));
}

}  // namespace

Store::Implementation::~Implementation() {
  if (pager) pager->discard();
  for (Attribute& attribute : attributes)
    for (auto& level : attribute.levels) pager->detach(*level);
  attributes.clear();
  if (!on_disk() || !writable) return;
  // A store that was never committed cannot be opened by anybody: leave nothing of it.
  if (sequence == 0)
    remove_uncommitted(path);
  else if (!failed)  // a commit that failed may yet turn out to have reached the disk
    remove_left_over_files(path);
}

std::filesystem::path Store::Implementation::level_path(std::uint32_t number, int level) const {
  return on_disk() ? path / level_file_name(number, level) : std::filesystem::path();
}

std::unique_ptr<LevelFile> Store::Implementation::open_level(
    const Attribute& attribute, const AttributeSchema& schema, int level, OpenMode mode,
    std::span<const BlockEntry> entries) const {
  auto file = std::make_unique<LevelFile>();
  file->geometry = LevelGeometry(base.edge_count(), base.border_edges(), level - options.base_level,
                                 schema.record_bytes(), options.block_bytes);
  file->table = BlockTable(uuid, attribute.number, level, file->geometry.block_count());
  std::ranges::copy(entries, file->table.entries().begin());
  file->path = level_path(attribute.number, level);
  file->writable = mode != OpenMode::kRead;
  const LevelSpec spec{file->path,
                       mode,
                       file->geometry,
                       file->table,
                       options.backend_options,
                       component_bytes(schema.type)};
  file->backend = backend.open(spec);
  if (journal)
    file->backend = std::make_unique<GuardedBackend>(std::move(file->backend), spec,
                                                     attribute.number, level, *journal);
  pager->attach(*file);
  return file;
}

void Store::Implementation::make_ready() {
  if (on_disk() && writable && writes_in_place() && options.durability == Durability::kCommit)
    journal = std::make_unique<RollbackJournal>(path, uuid, sequence);
  const auto processors =
      static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 64u));
  pager = std::make_unique<Pager>(
      options.budget_bytes,
      options.io_threads.value_or(backend.traits.compressed ? processors : 1));
}

Store::Store(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

Store Store::create(const std::filesystem::path& path, BaseMesh base, const StoreOptions& options,
                    const BackendRegistry& backends) {
  check_options(options);
  check_resources(options.budget_bytes, options.io_threads);
  auto state = std::make_unique<Implementation>();
  state->backend = backends.find(options.backend);
  state->backend.validate(options.backend_options);
  state->base = std::move(base);
  state->options = options;
  state->uuid = random_uuid();
  state->writable = true;
  encode_manifest(state->manifest());  // refuses names that no manifest holds, before any work
  if (path.empty()) {
    if (state->backend.traits.durable)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("create store: backend {} needs a path", options.backend));
  } else {
    remove_if_never_committed(path);
    if (std::filesystem::exists(std::filesystem::symlink_status(path)))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("create {}: it exists already", path.native()));
    make_directory(path);
    try {
      state->lock = StoreLock(path / kLockName, true, true);
    } catch (...) {
      std::error_code ignored;  // if somebody else took the directory it is not empty, and stays
      std::filesystem::remove(path, ignored);
      throw;
    }
    state->path = path;
    create_blank_manifest(path / kManifestName);
    state->base_mesh_size = write_base_mesh_file(path / kBaseMeshName, state->base);
  }
  state->make_ready();
  return Store(std::move(state));
}

Store Store::open(const std::filesystem::path& path, const OpenOptions& options,
                  const BackendRegistry& backends) {
  check_resources(options.budget_bytes, options.io_threads);
  if (!std::filesystem::is_directory(path))
    throw Error(ErrorCode::kNotFound, fmt::format("open {}: no such store", path.native()));
  auto state = std::make_unique<Implementation>();
  state->path = path;
  state->writable = false;
  state->lock = lock_recovered(path, options.writable, options.durability);
  const Manifest manifest = read_manifest(path / kManifestName);
  state->sequence = manifest.sequence;
  state->uuid = manifest.uuid;
  state->next_number = manifest.next_attribute_number;
  state->options.backend = manifest.backend;
  state->options.backend_options = {manifest.codec, manifest.filter};
  state->options.layout = manifest.layout;
  state->options.scheme = manifest.scheme;
  state->options.base_level = manifest.base_level;
  state->options.block_bytes = manifest.block_bytes;
  state->options.durability = options.durability;
  state->options.budget_bytes = options.budget_bytes;
  state->options.io_threads = options.io_threads;
  try {
    state->backend = backends.find(manifest.backend);
    state->backend.validate(state->options.backend_options);
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("open {}: {}", (path / kManifestName).native(), error.what()));
  }
  if (!state->backend.traits.durable)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: backend '{}' keeps nothing on disk",
                            (path / kManifestName).native(), manifest.backend));
  state->base_mesh_size = {manifest.base_mesh_bytes, manifest.base_mesh_checksum};
  state->base = read_base_mesh_file(path / kBaseMeshName, state->base_mesh_size);
  state->writable = options.writable;
  state->make_ready();
  state->read_version(manifest, options.writable ? OpenMode::kReadWrite : OpenMode::kRead);
  return Store(std::move(state));
}

bool Store::has_commit(const std::filesystem::path& path) {
  return !std::filesystem::is_directory(path) || !is_uncommitted(path);
}

const std::filesystem::path& Store::path() const { return implementation_->path; }
const BaseMesh& Store::base() const { return implementation_->base; }
const StoreOptions& Store::options() const { return implementation_->options; }
const StoreUuid& Store::uuid() const { return implementation_->uuid; }
std::uint64_t Store::sequence() const { return implementation_->sequence; }
BackendTraits Store::backend_traits() const { return implementation_->backend.traits; }
int Store::base_level() const { return implementation_->options.base_level; }
Pager& Store::pager() { return *implementation_->pager; }
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
                fmt::format("add attribute '{}': expected a name of 1 to 31 characters of "
                            "[A-Za-z0-9_-] and 1 to 255 components",
                            schema.name));
  if (has_attribute(schema.name) || attributes().size() >= kMaxAttributes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add attribute '{}': {}", schema.name,
                            has_attribute(schema.name) ? "the name is taken"
                                                       : "the store holds 59 already"));
  if (state.next_number == std::numeric_limits<std::uint32_t>::max())
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("add attribute '{}': the store has numbered all that it can", schema.name));
  Implementation::Attribute attribute;
  attribute.number = state.next_number++;
  attribute.base_bytes.resize(state.base.vertex_count() * schema.record_bytes());
  state.attributes.push_back(std::move(attribute));
  state.infos.push_back({std::move(schema), base_level()});
  return static_cast<AttributeId>(state.infos.size() - 1);
}

void Store::add_level(AttributeId attribute) {
  Implementation& state = *implementation_;
  check_writable(state);
  AttributeInfo& info = state.infos[attribute];
  const int level = info.finest_level + 1;
  if (level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add level {} to '{}': the finest level there can be is {}", level,
                            info.schema.name, kMaxLevel));
  Implementation::Attribute& data = state.attributes[attribute];
  if (state.on_disk()) {
    // Left over by a run that ended before its commit.
    remove_file(state.level_path(data.number, level));
  }
  data.levels.push_back(state.open_level(data, info.schema, level, OpenMode::kCreate, {}));
  info.finest_level = level;
}

void Store::replace_attribute(AttributeId attribute, AttributeId replacement) {
  Implementation& state = *implementation_;
  check_writable(state);
  std::string name = state.infos[attribute].schema.name;
  if (attribute == replacement)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("replace attribute '{}': expected another one in its place", name));
  Implementation::Attribute& old = state.attributes[attribute];
  for (auto& level : old.levels) {
    state.pager->detach(*level);
    if (state.on_disk()) state.obsolete.push_back(level->path);
  }
  // Both versions that the manifest names have a file of base records.
  if (state.on_disk() && state.sequence > 0)
    for (const std::uint64_t version : {state.sequence, state.sequence - 1})
      state.obsolete.push_back(state.path / base_file_name(old.number, version));
  state.attributes[attribute] = std::move(state.attributes[replacement]);
  state.infos[attribute] = state.infos[replacement];
  state.infos[attribute].schema.name = std::move(name);
  state.attributes.erase(state.attributes.begin() + replacement);
  state.infos.erase(state.infos.begin() + replacement);
}

std::span<std::byte> Store::base_bytes(AttributeId attribute) {
  return implementation_->attributes[attribute].base_bytes;
}

const LevelFile& Store::level_file(AttributeId attribute, int level) const {
  return *implementation_->attributes[attribute]
              .levels[static_cast<std::size_t>(level - base_level() - 1)];
}

LevelFile& Store::level_file(AttributeId attribute, int level) {
  return *implementation_->attributes[attribute]
              .levels[static_cast<std::size_t>(level - base_level() - 1)];
}

void Store::check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const {
  const AttributeSchema& schema = attributes()[attribute].schema;
  if (schema.type != type || schema.components != components)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("attribute '{}' holds {} x {}, asked for {} x {}", schema.name,
                    to_string(schema.type), schema.components, to_string(type), components));
}

void Store::commit() {
  if (!implementation_->writable)
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: opened for reading", path().native()));
  if (implementation_->failed)
    throw Error(ErrorCode::kBadState,
                fmt::format("commit {}: refused since an earlier one failed; reopen the store",
                            path().native()));
  try {
    implementation_->pager->flush();
    if (implementation_->on_disk())
      implementation_->write_version();
    else
      ++implementation_->sequence;
  } catch (...) {
    // The manifest's new slot may be on the disk or not. What were overwritten now belongs to both
    // versions, and the journal has it for the older one only.
    implementation_->failed = true;
    implementation_->pager->refuse_writes();
    throw;
  }
}

void Store::close() { implementation_.reset(); }

std::uint64_t Store::stored_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& attribute : implementation_->attributes) {
    bytes += attribute.base_bytes.size();
    for (const auto& level : attribute.levels) bytes += level->backend->stored_bytes();
  }
  return bytes + implementation_->base_mesh_size.bytes;
}

}  // namespace plait
