#include "plait/structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>
#include <utility>

#include "plait/error.h"
#include "store/base_mesh_file.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/manifest.h"
#include "store/recovery.h"
#include "store/stored_geometry.h"

namespace plait {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kTablesHeaderBytes = 16;

void add_names(const Manifest& manifest, std::set<std::string>& names) {
  names.insert(tables_file_name(manifest.sequence));
  for (const ManifestAttribute& attribute : manifest.attributes) {
    names.insert(base_file_name(attribute.number, manifest.sequence));
    for (int level = manifest.base_level + 1; level <= attribute.finest_level; ++level)
      names.insert(level_file_name(attribute.number, level));
  }
}

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

/// Runs `check`; what it finds damaged or missing becomes a reason, other errors pass.
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

/// The checks of one version, file after file.
class StructureCheck {
 public:
  StructureCheck(const Directory& store, const BackendRegistry& backends, const Manifest& manifest,
                 StoreStructure& result)
      : store_(store),
        backend_(backends.find(manifest.backend)),
        manifest_(manifest),
        result_(result) {
    backend_.validate(result.options.backend_options);
  }

  void run() {
    check_base_mesh();
    const std::optional<std::vector<std::byte>> tables =
        check_whole(named(StoreFile::kBlockTables, tables_file_name(manifest_.sequence), "",
                          StoredSize{manifest_.tables_bytes, manifest_.tables_checksum}));
    entries_known_ = tables.has_value() && !base_damaged_;
    if (entries_known_) entries_ = std::span(*tables).subspan(kTablesHeaderBytes);
    for (const ManifestAttribute& attribute : manifest_.attributes) {
      const std::uint64_t base_bytes = manifest_.vertex_count * attribute.schema.record_bytes();
      check_whole(named(StoreFile::kBaseRecords,
                        base_file_name(attribute.number, manifest_.sequence), attribute.schema.name,
                        StoredSize{base_bytes, attribute.base_checksum}));
      for (int level = manifest_.base_level + 1; level <= attribute.finest_level; ++level)
        check_level(attribute, level);
    }
  }

 private:
  void report(DamagedFile file, std::string reason) {
    file.reason = std::move(reason);
    result_.damaged.push_back(std::move(file));
  }

  void check_base_mesh() {
    const StoredSize expected{manifest_.base_mesh_bytes, manifest_.base_mesh_checksum};
    ++result_.files;
    const auto reason = reason_of([&] {
      BaseMesh mesh = read_base_mesh_file(File(store_, kBaseMeshName, OpenMode::kRead), expected);
      if (mesh.vertex_count() != manifest_.vertex_count ||
          mesh.edge_count() != manifest_.edge_count || mesh.face_count() != manifest_.face_count ||
          mesh.border_edge_count() != manifest_.border_edge_count)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: its counts are not those of the manifest",
                                store_.path_of(kBaseMeshName).native()));
      result_.base = std::move(mesh);
    });
    base_damaged_ = reason.has_value();
    if (reason) report(named(StoreFile::kBaseMesh, kBaseMeshName, "", expected), *reason);
  }

  /// The file's bytes if they are what the manifest says.
  std::optional<std::vector<std::byte>> check_whole(DamagedFile expected) {
    std::vector<std::byte> bytes;
    const fs::path path = store_.path_of(expected.name);
    ++result_.files;
    auto reason = reason_of([&] {
      const File file(store_, expected.name, OpenMode::kRead);
      if (file.size() != expected.expected_bytes)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: {} bytes, expected {}", path.native(), file.size(),
                                expected.expected_bytes));
      bytes.resize(expected.expected_bytes);
      file.read_at(0, bytes);
      if (!is_content_of(expected, bytes))
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: checksum {:016x}, expected {:016x}", path.native(),
                                checksum_of(bytes), expected.expected_checksum));
      if (expected.kind == StoreFile::kBlockTables && bytes.size() < kTablesHeaderBytes)
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: no header of block tables", path.native()));
    });
    if (!reason) return bytes;
    report(std::move(expected), std::move(*reason));
    return std::nullopt;
  }

  void check_level(const ManifestAttribute& attribute, int level) {
    DamagedFile found = named(StoreFile::kLevel, level_file_name(attribute.number, level),
                              attribute.schema.name, level);
    ++result_.files;
    if (entries_known_) found.expected_level = expected_level(attribute, level);
    const std::unique_ptr<LevelFile>& file = found.expected_level;
    auto reason = reason_of([&] {
      if (!file)
        File(store_, found.name, OpenMode::kRead);
      else
        backend_.open(LevelSpec{store_, found.name, OpenMode::kRead, file->geometry, file->table,
                                result_.options.backend_options,
                                component_bytes(attribute.schema.type)});
    });
    if (reason) report(std::move(found), std::move(*reason));
  }

  /// nullptr once the tables turned out too short for their levels.
  std::unique_ptr<LevelFile> expected_level(const ManifestAttribute& attribute, int level) {
    auto file = std::make_unique<LevelFile>();
    file->geometry =
        stored_geometry(manifest_, result_.base, attribute, level, store_.path_of(kManifestName));
    const std::uint64_t blocks = file->geometry.block_count();
    if (entries_.size() / sizeof(BlockEntry) < blocks) {
      entries_known_ = false;
      return nullptr;
    }
    file->path = store_.path_of(level_file_name(attribute.number, level));
    file->writable = false;
    file->table = BlockTable(manifest_.uuid, attribute.number, level, blocks);
    const std::size_t bytes = blocks * sizeof(BlockEntry);
    if (bytes > 0) std::memcpy(file->table.entries().data(), entries_.data(), bytes);
    entries_ = entries_.subspan(bytes);
    return file;
  }

  const Directory& store_;
  const BackendRegistry::Entry& backend_;
  const Manifest& manifest_;
  StoreStructure& result_;
  bool base_damaged_ = false, entries_known_ = false;
  std::span<const std::byte> entries_;  ///< of the levels to come
};

/// What the other slot of the manifest says, and whose files those in the directory are.
void look_around(const Directory& store, const Manifest& newest, StoreStructure& result) {
  std::set<std::string> names = {kManifestName, kBaseMeshName, kLockName, kJournalName};
  add_names(newest, names);
  const File file(store, kManifestName, OpenMode::kRead);
  const std::uint64_t offset = (newest.sequence + 1) % 2 * kManifestSlotBytes;
  ManifestSlot slot{};
  const bool there = file.size() >= offset + kManifestSlotBytes;
  if (there) file.read_at(offset, slot);
  if (there && is_whole_slot(slot)) {
    try {
      add_names(decode_manifest(slot, file.path()), names);
    } catch (const Error& error) {
      result.notes.push_back(fmt::format("the older version: {}", error.what()));
    }
  } else if (!there || std::ranges::any_of(slot, [](std::byte b) { return b != std::byte{0}; })) {
    const bool newer = store.contains(tables_file_name(newest.sequence + 1));
    result.notes.push_back(fmt::format(
        "manifest: the slot at byte {} is {}; {}version {} is the newest whole one", offset,
        there ? "damaged" : "missing",
        newer ? fmt::format("a version {} was begun or committed, ", newest.sequence + 1) : "",
        newest.sequence));
  }
  for (const std::string& name : store.names())
    if (!names.contains(name)) result.left_over.push_back(name);
}

}  // namespace

StoreStructure check_structure(const fs::path& path, const BackendRegistry& backends) {
  const Directory store = open_store_directory(path);
  const StoreLock lock = lock_recovered(store, false, Durability::kCommit);
  const Manifest manifest = read_manifest(store);
  StoreStructure result;
  result.sequence = manifest.sequence;
  result.files = 1;
  result.options.backend = manifest.backend;
  result.options.backend_options = {manifest.codec, manifest.filter};
  result.options.layout = manifest.layout;
  result.options.scheme = manifest.scheme;
  result.options.base_level = manifest.base_level;
  result.options.block_bytes = manifest.block_bytes;
  for (const ManifestAttribute& attribute : manifest.attributes)
    result.attributes.push_back({attribute.schema, attribute.finest_level});
  StructureCheck(store, backends, manifest, result).run();
  look_around(store, manifest, result);
  return result;
}

bool is_content_of(const DamagedFile& file, std::span<const std::byte> bytes) {
  return bytes.size() == file.expected_bytes && checksum_of(bytes) == file.expected_checksum;
}

void replace_file(const fs::path& path, std::uint64_t sequence, const std::string& name,
                  const Directory& from_directory, const std::string& from) {
  const Directory store = open_store_directory(path);
  const StoreLock lock = lock_recovered(store, true, Durability::kCommit);
  if (const std::uint64_t found = read_manifest(store).sequence; found != sequence)
    throw Error(
        ErrorCode::kBusy,
        fmt::format("replace {}: it is of version {}, and somebody has committed version {}",
                    store.path_of(name).native(), sequence, found));
  File file(from_directory, from, OpenMode::kReadWrite);
  file.sync();
  file.close();
  from_directory.rename(from, store, name);
  store.sync();
}

}  // namespace plait
