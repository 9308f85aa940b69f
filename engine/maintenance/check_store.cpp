#include "plait/extend/check_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "format/base_mesh_file.h"
#include "format/bounds_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/view_file.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "store/parts/shard_place.h"
#include "store/recovery.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace fs = std::filesystem;
namespace {

DamagedFile named(StoreFile kind, std::string name, std::string attribute = {}, int level = 0) {
  DamagedFile file;
  file.kind = kind;
  file.name = std::move(name);
  file.attribute = std::move(attribute);
  file.level = level;
  return file;
}

DamagedFile named(StoreFile kind, std::string name, std::string attribute, StoredSize expected) {
  DamagedFile file = named(kind, std::move(name), std::move(attribute));
  file.expected_bytes = expected.bytes;
  file.expected_checksum = expected.checksum;
  return file;
}

/// Runs `check`. Returns the message of an error about damaged or missing data, and throws others.
template <class Check>
std::optional<std::string> reason_of(Check check) {
  try {
    check();
    return std::nullopt;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound) throw;
    return error.what();
  }
}

/// Checks one version, file after file, as Store::open does, but goes on after a damaged file.
class StructureCheck {
 public:
  StructureCheck(const Directory& store, const StoredVersion& version,
                 const RegisteredBackend& backend, StoreCheck& result)
      : store_(store),
        version_(version),
        description_(version.description()),
        backend_(backend),
        result_(result) {}

  void run() {
    const bool mesh_known =
        check(named(StoreFile::kBaseMesh, kBaseMeshName, "",
                    StoredSize{description_.base_mesh_bytes, description_.base_mesh_checksum}),
              [&] { result_.base = version_.read_base_mesh(); });
    if (store_.contains(kBaseIndexName))
      check(named(StoreFile::kBaseIndex, kBaseIndexName),
            [&] { version_.check_base_index(mesh_known ? &result_.base : nullptr); });
    bool base_known = mesh_known;
    if (description_.depths && !check_depths(base_known)) {
      result_.depths_lost = true;
      base_known = false;
    }
    std::vector<StoredLevel> levels = version_.levels(result_.base);
    const bool log_known = !version_.has_log() || check_log();
    const bool tables_known = check(named(StoreFile::kBlockTables, version_.version_name(), "",
                                          StoredSize{version_.manifest().version_bytes,
                                                     version_.manifest().version_checksum}),
                                    [&] {
                                      if (base_known && log_known)
                                        version_.read_tables_into(levels);
                                      else
                                        version_.check_version_file();
                                    }) &&
                              log_known;
    std::set<std::uint32_t> unknown_shards;
    if (base_known && tables_known) unknown_shards = check_shard_tables(levels);
    for (const FaceAttributeRecord& attribute : description_.face_attributes) {
      const std::uint64_t bytes = description_.face_count * attribute.schema.record_bytes();
      check(named(StoreFile::kFaceRecords, version_.face_records_name(attribute),
                  attribute.schema.name, StoredSize{bytes, attribute.checksum}),
            [&] { version_.read_face_records(attribute); });
    }
    for (std::size_t at = 0; at < description_.attributes.size(); ++at) {
      const AttributeRecord& attribute = description_.attributes[at];
      if (log_known)
        check(
            named(StoreFile::kBaseRecords, version_.base_records_name(attribute),
                  attribute.schema.name, StoredSize{attribute.base_bytes, attribute.base_checksum}),
            [&] {
              if (mesh_known)
                version_.read_base_records(attribute, result_.base);
              else
                version_.check_base_file(attribute);
            });
      for (StoredLevel& level : levels)
        if (level.attribute != at)
          continue;
        else if (version_.shard_count() == 0)
          check_files(level, base_known && tables_known);
        else
          check_shards(level, base_known && tables_known, unknown_shards);
    }
  }

 private:
  /// Returns whether the file is whole. Reports it otherwise.
  template <class Read>
  bool check(DamagedFile file, Read read) {
    if (counted_.insert(file.name).second) ++result_.files;
    std::optional<std::string> reason = reason_of(read);
    if (!reason) return true;
    file.reason = std::move(*reason);
    result_.damaged.push_back(std::move(file));
    return false;
  }

  bool check_log() {
    return check(named(StoreFile::kChangeLog, version_.log_name()), [&] { version_.changes(); });
  }

  /// Without the base mesh, only that the file is there.
  bool check_depths(bool base_known) {
    DamagedFile file = named(StoreFile::kDepths, kDepthsName, "",
                             StoredSize{description_.face_count, description_.depths->checksum});
    return check(std::move(file), [&] {
      if (base_known)
        result_.base = version_.with_depths(result_.base);
      else
        File(store_, kDepthsName, OpenMode::kRead);
    });
  }

  /// Checks the block tables of all shards. Returns those whose tables are not known.
  std::set<std::uint32_t> check_shard_tables(const std::vector<StoredLevel>& levels) {
    std::set<std::uint32_t> unknown;
    for (std::uint32_t shard = 0; shard < version_.shard_count(); ++shard)
      if (!check(named(StoreFile::kBlockTables, tables_file_name(result_.sequence, shard)),
                 [&] { version_.check_shard_tables(levels, shard); }))
        unknown.insert(shard);
    return unknown;
  }

  void check_shards(const StoredLevel& level, bool content_known,
                    const std::set<std::uint32_t>& unknown) {
    const std::vector<std::string> names = level.file_names();
    for (std::uint32_t shard = 0; shard < version_.shard_count(); ++shard) {
      if (!content_known || unknown.contains(shard)) {
        check_file(level, shard, {names[shard]}, false);
        continue;
      }
      StoredLevel alone = level;
      alone.geometry = level.geometry.shard(shard);
      alone.table =
          level.table.part(level.geometry.first_block(shard), alone.geometry.block_count());
      check_file(
          alone, shard,
          place_of({level.number, level.level, level.record.generation, shard, alone.geometry},
                   level.shares_files, backend_.traits),
          true);
    }
  }

  void check_files(const StoredLevel& level, bool content_known) {
    const std::vector<std::string> names = level.file_names();
    for (std::size_t file = 0; file < names.size(); ++file)
      check_file(level, file, {names[file]}, content_known);
  }

  void check_file(const StoredLevel& level, std::size_t file, const ShardPlace& place,
                  bool content_known) {
    const std::string& name = place.name;
    const AttributeSchema& schema = description_.attributes[level.attribute].schema;
    DamagedFile found = named(StoreFile::kLevel, name, schema.name, level.level);
    found.file = file;
    if (!content_known) {
      check(std::move(found), [&] { File(store_, name, OpenMode::kRead); });
      return;
    }
    found.expected_level = std::make_unique<LevelFile>();
    LevelFile& expected = *found.expected_level;
    expected.geometry = level.geometry;
    expected.table = level.table;
    expected.path = store_.path_of(name);
    expected.pipeline = level.record.pipeline;
    expected.writable = false;
    check(std::move(found), [&] {
      LevelSpec spec{store_,         name,   OpenMode::kRead,  expected.geometry,
                     expected.table, schema, expected.pipeline};
      place.put_into(spec);
      backend_.open({})->open_level(spec);
    });
  }

  const Directory& store_;
  const StoredVersion& version_;
  const VersionDescription& description_;
  const RegisteredBackend& backend_;
  StoreCheck& result_;
  std::set<std::string> counted_;  ///< one file may have several levels
};

/// Reads the other slot of the manifest. Returns the version whose file it names; adds a note if it
/// is damaged.
std::optional<std::uint64_t> look_at_other_slot(const Directory& store, std::uint64_t newest,
                                                StoreCheck& result) {
  const File file(store, kManifestName, OpenMode::kRead);
  const std::uint64_t offset = (newest + 1) % 2 * kManifestSlotBytes;
  ManifestSlot slot{};
  const bool there = file.size() >= offset + kManifestSlotBytes;
  if (there) file.read_at(offset, slot);
  if (there && is_whole_slot(slot)) {
    try {
      if (!is_begun_slot(slot)) return decode_manifest(slot, file.path()).described;
    } catch (const Error& error) {
      result.notes.push_back(fmt::format("the older version: {}", error.what()));
    }
  } else if (!there || std::ranges::any_of(slot, [](std::byte b) { return b != std::byte{0}; })) {
    const bool newer = store.contains(version_file_name(newest + 1));
    result.notes.push_back(fmt::format(
        "manifest: the slot at byte {} is {}; {}version {} is the newest whole one", offset,
        there ? "damaged" : "missing",
        newer ? fmt::format("a version {} was begun or committed, ", newest + 1) : "", newest));
  }
  return {};
}

void find_left_overs(const Directory& store, const StoredVersion& version,
                     std::optional<std::uint64_t> older, StoreCheck& result) {
  std::set<std::string> names = version.file_names();
  names.insert({kManifestName, kBaseMeshName, kBaseIndexName, kLockName, kViewName, kPageName});
  if (version.description().depths) names.insert(kDepthsName);
  for (const AttributeRecord& attribute : version.description().attributes)
    names.insert(bounds_file_name(attribute.number));
  for (const std::string& name : store.names())
    if (!names.contains(name) && !(older && is_of_version_alone(name, *older)))
      result.left_over.push_back(name);
}

/// Damaged bounds are no damage of the store, because a program can make them again.
void look_at_bounds(const Directory& store, const VersionDescription& description,
                    StoreCheck& result) {
  if (result.base.face_count() != description.face_count) return;  // the base mesh is damaged
  for (const AttributeRecord& attribute : description.attributes) {
    const auto reason =
        reason_of([&] { check_bounds_file(store, attribute.number, description.face_count); });
    if (reason)
      result.notes.push_back(fmt::format("bounds of '{}', which can be made again: {}",
                                         attribute.schema.name, *reason));
  }
}

/// The same for the view; one of an earlier version is fine, because its readers can tell.
void look_at_view(const Directory& store, const StoredVersion& version, StoreCheck& result) {
  const VersionDescription& description = version.description();
  const FaceDepths* const depths = result.base.depths();
  if (description.depths && depths == nullptr) return;  // they are damaged
  const auto reason = reason_of([&] {
    read_view_file(store,
                   {version.manifest().uuid, description.vertex_count, description.face_count,
                    depths ? depths->of_faces() : std::span<const std::uint8_t>()});
  });
  if (reason) result.notes.push_back(fmt::format("the view, which can be made again: {}", *reason));
}

}  // namespace

StoreCheck check_store(const fs::path& path, const BackendRegistry& backends) try {
  const Directory store = open_store_directory(path);
  StoreCheck result;
  result.files = 1;
  result.lock = why_unusable_lock(store).value_or("");
  const Manifest manifest = read_manifest(store);
  const std::uint64_t newest = manifest.sequence;
  std::optional<StoredVersion> opened;
  // The capture calls open_for_reading() outside reason_of() on purpose: its errors concern the
  // whole store.
  const std::string version_name = version_file_name(manifest.described);
  const auto reason = store.contains(version_name)
                          ? reason_of([&, version = open_for_reading(store)]() mutable {
                              opened.emplace(store, std::move(version));
                            })
                          : reason_of([&] { File(store, version_name, OpenMode::kRead); });
  result.sequence = opened ? opened->manifest().sequence : newest;
  const auto older = look_at_other_slot(store, result.sequence, result);
  if (reason) {
    DamagedFile file = named(StoreFile::kDescription, version_name);
    file.reason = *reason;
    result.damaged.push_back(std::move(file));
    return result;
  }
  const StoredVersion& version = *opened;
  const VersionDescription& description = version.description();
  const RegisteredBackend& backend = version.find_backend(backends);
  result.options = version.options();
  result.provenance = description.provenance;
  result.in_shards = version.shard_count() > 0;
  result.base_mesh_checksum = description.base_mesh_checksum;
  for (const AttributeRecord& attribute : description.attributes)
    result.attributes.push_back({attribute.schema, description.finest_level(attribute)});
  StructureCheck(store, version, backend, result).run();
  find_left_overs(store, version, older, result);
  look_at_bounds(store, description, result);
  look_at_view(store, version, result);
  return result;
} catch (const std::bad_alloc&) {
  throw out_of_memory("check " + path.native());
}

StoreDescription describe_store(const fs::path& path) try {
  const Directory store = open_store_directory(path);
  const StoredVersion version(store, open_for_reading(store));
  const VersionDescription& described = version.description();
  StoreDescription result;
  result.uuid = version.manifest().uuid;
  result.sequence = version.manifest().sequence;
  result.options = version.options();
  result.provenance = described.provenance;
  result.vertex_count = described.vertex_count;
  result.edge_count = described.edge_count;
  result.face_count = described.face_count;
  result.border_edge_count = described.border_edge_count;
  for (const AttributeRecord& attribute : described.attributes) {
    result.attributes.push_back({attribute.schema, described.finest_level(attribute), {}});
    for (const LevelRecord& level : attribute.levels)
      result.attributes.back().pipelines.push_back(level.pipeline);
  }
  for (const FaceAttributeRecord& attribute : described.face_attributes)
    result.face_attributes.push_back(attribute.schema);
  result.texts = described.texts;
  return result;
} catch (const std::bad_alloc&) {
  throw out_of_memory("describe " + path.native());
}

PLAIT_END_NAMESPACE
