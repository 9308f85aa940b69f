// Creates, opens and closes stores.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <random>
#include <system_error>

#include "base/damage.h"
#include "format/depths_file.h"
#include "format/file_names.h"
#include "io/control_groups.h"
#include "io/unpublished.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/notices.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"
#include "store/generation_volume.h"
#include "store/left_overs.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_volume.h"
#include "store/recovery.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The scratch memory of a volume is at most this part of the budget.
constexpr std::uint64_t kScratchShare = 4;

StoreUuid random_uuid() {
  std::random_device device;
  StoreUuid uuid;
  for (std::byte& byte : uuid) byte = static_cast<std::byte>(device() & 0xff);
  return uuid;
}

void check_options(const StoreOptions& options, const Provenance& provenance) {
  if (options.block_bytes != 0) check_block_bytes(options.block_bytes, "create store");
  if (provenance.base_level < 0 || provenance.base_level > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create store: base level {}, expected 0 to {}", provenance.base_level,
                            kMaxLevel));
}

bool names_pipelines(const StoreOptions& options) {
  return options.pipeline_of || (options.pipeline && *options.pipeline != LevelPipelines());
}

void check_resources(std::uint64_t budget_bytes, std::optional<int> io_threads) {
  if (io_threads && (*io_threads < 0 || *io_threads > 64))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("open store: {} I/O threads, expected 0 to 64", *io_threads));
  if (budget_bytes < kLeastBudgetBytes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("open store: budget {} bytes, expected at least {}", budget_bytes,
                            kLeastBudgetBytes));
}

}  // namespace

Store::Implementation::~Implementation() {
  if (pager) pager->discard();
  for (Attribute& attribute : attributes)
    for (auto& level : attribute.levels) pager->detach(*level);
  attributes.clear();
  snapshot.reset();
  telling = nullptr;
  generations = nullptr;
  volume.reset();  // its scratch memory is part of the budget, which ends with the pager
  if (!on_disk() || !writable || is_part()) return;
  // Nobody can open a store that was never committed, so all its files are removed.
  if (sequence == 0)
    remove_uncommitted(directory);
  else if (!failed)  // after a failed commit, the new version may be on the disk, and needs its
                     // files
    try {
      remove_old_versions(directory);
    } catch (const std::exception&) {  // the next writer removes the files
    }
}

std::unique_ptr<LevelFile> Store::Implementation::open_level(StoredLevel level,
                                                             const AttributeSchema& schema,
                                                             OpenMode mode) const {
  check_pipeline_of_depths(*this, schema, level.record.pipeline);
  const bool is_made_part = is_part() && mode != OpenMode::kRead;
  ShardPlace place{level.file_names().front()};
  if (is_made_part)
    place =
        place_of({level.number, level.level, level.record.generation, only_shard, level.geometry},
                 shares_files, backend.traits);
  const std::string& name = place.name;
  const Directory& in = is_made_part && in_shards ? made_in : directory;
  auto file = std::make_unique<LevelFile>();
  file->geometry = level.geometry;
  file->table = std::move(level.table);
  file->path = in.path_of(name);
  file->attribute = schema.name;
  file->traits = backend.traits;
  file->pipeline = level.record.pipeline;
  file->writable = mode != OpenMode::kRead;
  LevelSpec spec{in, name, mode, file->geometry, file->table, schema, file->pipeline};
  place.put_into(spec);
  spec.surroundings = surroundings();
  for (const HeldVersion& older : held)
    for (const StoredLevel& same : older.levels)
      if (same.file_names().front() == name) spec.held.push_back({older.version, &same.table});
  file->backend = volume->open_level(spec);
  pager->set_aside(volume->scratch_bytes());
  pager->attach(*file);
  if (file->writable) fix_context_of(*file);
  return file;
}

LevelSurroundings Store::Implementation::surroundings() const {
  LevelSurroundings result;
  result.base_level = provenance.base_level;
  // Only filters look at the mesh. Nothing else that opening does reads all of it.
  if (backend.traits.compressed) {
    result.mesh = base.topology();
    result.positions = base.positions();
    result.depths = base.depths();
  }
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    AttributeLevels& levels = result.attributes.emplace_back();
    levels.number = attributes[i].record.number;
    levels.schema = infos[i].schema;
    // Records in a file are read by nobody who decodes.
    if (attributes[i].base_bytes.file() == nullptr) levels.base = attributes[i].base_bytes;
    for (const auto& level : attributes[i].levels) levels.levels.push_back(&level->geometry);
  }
  return result;
}

void Store::Implementation::fix_context_of(const LevelFile& level) const {
  if (level.traits.in_memory) return;
  const auto entries = level.table.entries();
  // All blocks of one encoding need blocks of the same levels. Raw blocks need none.
  for (const BlockEncoding encoding : {BlockEncoding::kEncoded, BlockEncoding::kPredicted}) {
    const auto written = std::ranges::find(entries, encoding, &BlockEntry::encoding);
    if (written == entries.end()) continue;
    std::array<ContextBlock, kMostContextBlocks> needed;
    const std::size_t count =
        level.backend->read_context(static_cast<std::uint64_t>(written - entries.begin()), needed);
    for (const ContextBlock& context : std::span(needed).first(count))
      for (const Attribute& attribute : attributes)
        if (attribute.record.number == context.attribute)
          attribute.levels[static_cast<std::size_t>(context.level - provenance.base_level - 1)]
              ->is_fixed = true;
  }
}

void Store::Implementation::open_volume(int threads) {
  volume = backend.open({options.budget_bytes / kScratchShare, threads});
  telling = dynamic_cast<const TellingVolume*>(volume.get());
  if (in_shards)
    volume = std::make_unique<ShardVolume>(std::move(volume), shares_files, backend.traits);
  else if (is_part())
    return;
  else if (on_disk() && backend.traits.overwrites_in_place) {
    auto around = std::make_unique<GenerationVolume>(std::move(volume), directory, sequence,
                                                     committed.log, writable);
    generations = around.get();
    volume = std::move(around);
  }
}

void Store::Implementation::tell(StoreEvent::Kind kind, const Stopwatch& watch) const noexcept {
  if (!options.events.call) return;
  StoreEvent event;
  event.kind = kind;
  event.store = path.native();
  event.version = sequence;
  event.duration_ns = static_cast<std::uint64_t>(1e9 * watch.seconds());
  options.events.tell(event);
}

void Store::Implementation::note_missing_locks() {
  if (const auto missing = missing_protection(lock, directory)) notices.push_back(*missing);
}

std::vector<std::string> notices(const Store& store) {
  const Store::Implementation& state = StoreAccess::state(store);
  std::vector<std::string> lines = state.notices;
  if (state.telling)
    for (std::string& line : state.telling->notices()) lines.push_back(std::move(line));
  return lines;
}

void tell_notices(const Store& store, const std::function<void(const std::string&)>& warn,
                  const std::filesystem::path& named) {
  if (!warn) return;
  const std::filesystem::path& path = StoreAccess::state(store).path;
  for (const std::string& line : notices(store))
    warn(with_final_name(line, path, named.empty() ? path : named));
}

void Store::Implementation::make_ready() {
  const int processors = std::min(usable_processors(), 64);
  const int io_threads = options.io_threads.value_or(processors);
  open_volume(std::max(processors, io_threads));
  StoreEvents of_blocks = options.events;
  if (of_blocks.call)
    of_blocks.call = [this](const StoreEvent& event) {
      StoreEvent named = event;
      named.store = path.native();
      options.events.call(named);
    };
  pager = std::make_unique<Pager>(options.budget_bytes, io_threads, std::move(of_blocks));
}

Store Store::create(const std::filesystem::path& path, LaidOutMesh mesh,
                    const StoreOptions& options, const BackendRegistry& backends,
                    const Provenance& provenance) try {
  const Stopwatch watch;
  Provenance facts = provenance;
  if (mesh.kind != LayoutKind::kGiven) facts.layout = to_string(mesh.kind);
  check_options(options, facts);
  check_resources(options.budget_bytes, options.io_threads);
  auto state = std::make_unique<Implementation>();
  state->options = options;
  if (options.backend == kAutomaticBackend)
    state->options.backend =
        backends.choose({path, options.expected_bytes, names_pipelines(options), {}}).name;
  state->backend = backends.find(state->options.backend);
  state->backend.check_machine();
  if (options.block_bytes == 0)
    state->options.block_bytes = default_block_bytes(state->backend.traits);
  if (path.empty() == state->backend.traits.durable)
    throw Error(ErrorCode::kInvalidArgument,
                path.empty()
                    ? fmt::format("create store: backend {} needs a path", state->options.backend)
                    : fmt::format("create store {}: backend {} writes no files: expected an empty "
                                  "path",
                                  path.native(), state->options.backend));
  state->base = std::move(mesh.mesh);
  if (!options.pipeline) state->options.pipeline = state->backend.default_pipeline;
  state->backend.check_pipelines(*state->options.pipeline, {});
  state->uuid = random_uuid();
  state->writable = true;
  state->provenance = state->first_provenance = facts;
  encode_description(
      state->description());  // refuses text that a version cannot record, before any work
  if (!path.empty()) {
    state->directory = claim_store_directory(path, options.durability);
    state->path = path;  // after this, the destructor removes the files
    state->lock = StoreLock(state->directory, LockFor::kCreating);
    state->lock.sign();
    state->note_missing_locks();
    state->base_mesh_size = write_base_mesh_file(state->directory, state->base);
    if (const FaceDepths* const depths = state->base.depths())
      state->depths_checksum =
          write_depths_file(state->directory, *depths, state->provenance.base_level);
  }
  state->make_ready();
  state->tell(StoreEvent::Kind::kOpened, watch);
  return Store(std::move(state));
} catch (const std::bad_alloc&) {
  throw out_of_memory("create " + path.native());
}

Store Store::open(const std::filesystem::path& path, const OpenOptions& options,
                  const BackendRegistry& backends) try {
  const Stopwatch watch;
  check_resources(options.budget_bytes, options.io_threads);
  auto state = std::make_unique<Implementation>();
  state->path = path;
  state->directory = open_store_directory(path);
  state->writable = false;
  if (options.writable) {
    state->lock = lock_for_writing(state->directory, options.durability);
    state->note_missing_locks();
    remove_left_overs_of_repairs(state->directory, {});
    state->versions_read = remove_old_versions(state->directory);
  }
  StoredVersion version(state->directory, options.writable ? open_newest_version(state->directory)
                                                           : open_for_reading(state->directory));
  state->open_version(version, options, backends);
  if (!options.writable) state->version_file = std::move(version).release_file();
  state->tell(StoreEvent::Kind::kOpened, watch);
  return Store(std::move(state));
} catch (const std::bad_alloc&) {
  throw out_of_memory("open " + path.native());
} catch (const Error& error) {
  if (error.code() != ErrorCode::kCorruption) throw;
  throw with_cure(error);
}

void Store::Implementation::open_version(const StoredVersion& version, const OpenOptions& wanted,
                                         const BackendRegistry& backends) {
  const VersionDescription& description = version.description();
  committed = version.manifest();
  sequence = committed.sequence;
  uuid = version.manifest().uuid;
  next_number = first_made = description.next_attribute_number;
  base_mesh_size = {description.base_mesh_bytes, description.base_mesh_checksum};
  provenance = description.provenance;
  options = version.options();
  options.durability = wanted.durability;
  options.base_index = wanted.base_index;
  options.budget_bytes = wanted.budget_bytes;
  options.io_threads = wanted.io_threads;
  options.events = wanted.events;
  options.parallel_for = wanted.parallel_for;
  backend = version.find_backend(backends);
  if (wanted.writable && version.shard_count() > 0)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open {} for writing: its levels are in {} shards, which only passes "
                            "in parts can change (plait plan --pass); plait convert makes a store "
                            "in one piece",
                            path.native(), version.shard_count()));
  writable = wanted.writable;
  in_shards = version.shard_count() > 0;
  shares_files = description.shares_files;
  make_ready();
  version.check_base_sizes();
  if (std::optional<BaseMesh> indexed = version.open_base_index()) {
    base = *std::move(indexed);
    has_base_index = true;
  } else {
    base = version.read_base_mesh();
  }
  base = version.with_depths(std::move(base));
  if (description.depths) depths_checksum = description.depths->checksum;
  shards = version.shards();
  hold_versions();
  read_version(version, wanted.writable ? OpenMode::kReadWrite : OpenMode::kRead);
  held.clear();
  if (writable) {
    find_changed_records();
    note_committed();
  }
}

bool Store::has_commit(const std::filesystem::path& path) {
  std::error_code ignored;
  return !std::filesystem::is_directory(path, ignored) || !is_uncommitted(Directory(path));
}

PLAIT_END_NAMESPACE
