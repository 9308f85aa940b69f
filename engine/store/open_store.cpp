// Creates, opens and closes stores.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>
#include <system_error>
#include <thread>

#include "plait/edge_index.h"
#include "plait/error.h"
#include "plait/store.h"
#include "store/file_names.h"
#include "store/journaled_volume.h"
#include "store/recovery.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The scratch memory of a volume is at most this part of the budget.
constexpr std::uint64_t kScratchShare = 4;
/// A larger buffer does not make the journal faster.
constexpr std::uint64_t kMostJournalBufferBytes = 1 << 20;

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
  volume.reset();  // its scratch memory is part of the budget, which ends with the pager
  if (!on_disk() || !writable) return;
  // Nobody can open a store that was never committed, so all its files are removed.
  if (sequence == 0)
    remove_uncommitted(directory);
  else if (!failed)  // after a failed commit, the new version may be on the disk, and needs its
                     // files
    try {
      remove_old_versions(directory);
    } catch (...) {  // the next writer removes the files
    }
}

std::unique_ptr<LevelFile> Store::Implementation::open_level(StoredLevel level,
                                                             const AttributeSchema& schema,
                                                             OpenMode mode) const {
  const std::string name = level.file_name();
  auto file = std::make_unique<LevelFile>();
  file->geometry = level.geometry;
  file->table = std::move(level.table);
  file->path = directory.path_of(name);
  file->traits = backend.traits;
  file->pipeline = level.record.pipeline;
  file->writable = mode != OpenMode::kRead;
  LevelSpec spec{directory, name, mode, file->geometry, file->table, schema, file->pipeline};
  spec.surroundings = surroundings();
  for (const HeldVersion& older : held)
    for (const StoredLevel& same : older.levels)
      if (same.file_name() == name) spec.held.push_back({older.version, &same.table});
  file->backend = volume->open_level(spec);
  pager->set_aside(volume->scratch_bytes());
  pager->attach(*file);
  if (file->writable) fix_context_of(*file);
  return file;
}

LevelSurroundings Store::Implementation::surroundings() const {
  LevelSurroundings result{base.topology(), options.base_level, {}, base.positions()};
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    if (attributes[i].derived) continue;  // blocks are not encoded from computed ones
    AttributeLevels& levels = result.attributes.emplace_back();
    levels.number = attributes[i].record.number;
    levels.schema = infos[i].schema;
    levels.base = attributes[i].base_bytes;
    for (const auto& level : attributes[i].levels) levels.levels.push_back(&level->geometry);
  }
  return result;
}

void Store::Implementation::fix_context_of(const LevelFile& level) const {
  const auto entries = level.table.entries();
  // Raw and predicted blocks need no other block.
  const auto written = std::ranges::find(entries, BlockEncoding::kEncoded, &BlockEntry::encoding);
  if (written == entries.end() || level.traits.in_memory || level.is_derived) return;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count =
      level.backend->context(static_cast<std::uint64_t>(written - entries.begin()), needed);
  for (const ContextBlock& context : std::span(needed).first(count))
    for (const Attribute& attribute : attributes)
      if (attribute.record.number == context.attribute)
        attribute.levels[static_cast<std::size_t>(context.level - options.base_level - 1)]
            ->is_fixed = true;
}

void Store::Implementation::open_volume(int threads) {
  VolumeSpec spec{std::string(BackendRegistry::options_in(options.backend)),
                  options.budget_bytes / kScratchShare, threads};
  if (!on_disk() || !writable || !backend.traits.overwrites_in_place) {
    volume = backend.open(spec);
  } else if (options.overwriting == Overwriting::kNewGeneration) {
    auto made = std::make_unique<GenerationVolume>(backend.open(spec), directory, sequence);
    generations = made.get();
    volume = std::move(made);
  } else if (options.durability == Durability::kCommit) {
    const std::uint64_t buffer_bytes =
        std::clamp<std::uint64_t>(spec.most_scratch_bytes / 2, 1, kMostJournalBufferBytes);
    spec.most_scratch_bytes -= std::min(spec.most_scratch_bytes, buffer_bytes);
    journal = std::make_unique<RollbackJournal>(directory, uuid, sequence, buffer_bytes);
    volume = std::make_unique<JournaledVolume>(backend.open(spec), *journal);
  } else {
    volume = backend.open(spec);
  }
}

void Store::Implementation::make_ready() {
  const auto processors =
      static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 64u));
  const int io_threads = options.io_threads.value_or(backend.traits.compressed ? processors : 1);
  open_volume(std::max(processors, io_threads));
  pager = std::make_unique<Pager>(options.budget_bytes, io_threads, options.budget);
}

Store Store::create(const std::filesystem::path& path, BaseMesh base, const StoreOptions& options,
                    const BackendRegistry& backends) {
  check_options(options);
  check_resources(options.budget_bytes, options.io_threads);
  auto state = std::make_unique<Implementation>();
  state->backend = backends.find(options.backend);
  state->backend.validate(BackendRegistry::options_in(options.backend));
  state->derivations = backends.derivations();
  state->base = std::move(base);
  state->options = options;
  if (options.pipeline.empty()) state->options.pipeline = state->backend.default_pipeline;
  state->backend.validate_pipeline(state->options.pipeline, {});
  state->uuid = random_uuid();
  state->writable = true;
  state->provenance.layout = options.layout;
  state->provenance.base_level = options.base_level;
  encode_description(
      state->description());  // refuses text that a version cannot record, before any work
  if (path.empty()) {
    if (state->backend.traits.durable)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("create store: backend {} needs a path", options.backend));
  } else {
    state->directory = claim_store_directory(path, options.durability);
    state->path = path;  // after this, the destructor removes the files
    state->lock = StoreLock(state->directory, LockFor::kCreating);
    state->lock.sign();
    state->base_mesh_size = write_base_mesh_file(state->directory, state->base);
  }
  state->make_ready();
  return Store(std::move(state));
}

Store Store::create(const std::filesystem::path& path, LaidOutMesh mesh, StoreOptions options,
                    const BackendRegistry& backends) {
  options.layout = to_string(mesh.kind);
  return create(path, std::move(mesh.mesh), options, backends);
}

Store Store::open(const std::filesystem::path& path, const OpenOptions& options,
                  const BackendRegistry& backends) {
  check_resources(options.budget_bytes, options.io_threads);
  auto state = std::make_unique<Implementation>();
  state->path = path;
  state->directory = open_store_directory(path);
  state->writable = false;
  if (options.writable) {
    state->lock = lock_for_writing(state->directory, options.durability);
    state->versions_read = remove_old_versions(state->directory);
  }
  StoredVersion version(state->directory, options.writable ? open_newest_version(state->directory)
                                                           : open_for_reading(state->directory));
  const VersionDescription& description = version.description();
  state->sequence = version.manifest().sequence;
  state->uuid = version.manifest().uuid;
  state->next_number = description.next_attribute_number;
  state->base_mesh_size = {description.base_mesh_bytes, description.base_mesh_checksum};
  state->provenance = description.provenance;
  state->options = version.options();
  state->options.durability = options.durability;
  state->options.overwriting = options.overwriting;
  state->options.budget_bytes = options.budget_bytes;
  state->options.io_threads = options.io_threads;
  state->options.budget = options.budget;
  state->backend = version.find_backend(backends);
  state->derivations = backends.derivations();
  state->writable = options.writable;
  if (state->overwrites_in_place())
    state->version_file = keep_readers_out(state->directory, state->sequence);
  state->make_ready();
  state->base = version.read_base_mesh();
  state->hold_versions();
  state->read_version(version, options.writable ? OpenMode::kReadWrite : OpenMode::kRead);
  state->held.clear();
  if (!options.writable) state->version_file = std::move(version).release_file();
  return Store(std::move(state));
}

bool Store::has_commit(const std::filesystem::path& path) {
  std::error_code ignored;
  return !std::filesystem::is_directory(path, ignored) || !is_uncommitted(Directory(path));
}

PLAIT_END_NAMESPACE
