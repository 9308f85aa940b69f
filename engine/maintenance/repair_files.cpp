#include "maintenance/repair_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "format/base_index_file.h"
#include "format/base_records_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/recovery.h"
#include "store/stored_version.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kRepairPageBytes = 4096;

/// docs/format.md, "Level files".
std::uint64_t repaired_bytes(const LevelFile& level, bool compressed) {
  if (!compressed)
    return (level.geometry.total_bytes() + kRepairPageBytes - 1) / kRepairPageBytes *
           kRepairPageBytes;
  std::uint64_t end = 0;
  for (const BlockEntry& entry : level.table.entries())
    end = std::max(end, entry.offset + entry.stored_bytes);
  return end;
}

/// Nothing if the file does not have these bytes any more, or on a bad place of the disk.
std::optional<std::vector<std::byte>> bytes_left(const Directory& store, const std::string& name,
                                                 std::uint64_t offset, std::uint64_t bytes) try {
  const File file(store, name, OpenMode::kRead);
  if (offset > file.size() || bytes > file.size() - offset) return std::nullopt;
  std::vector<std::byte> left(bytes);
  file.read_at(offset, left);
  return left;
} catch (const Error&) {
  return std::nullopt;
}

struct FileRepair {
  const std::filesystem::path& path;
  const Directory store;
  const StoreCheck& check;
  const RepairOptions& options;
  Remaker& remaker;
  UnpublishedDirectory& scratch;

  /// Makes the file in the scratch directory. Returns why it is lost, or nothing if it is not.
  std::optional<std::string> why_lost(const DamagedFile& file) {
    if (file.kind == StoreFile::kBaseRecords) return why_base_records_lost(file);
    if (file.kind == StoreFile::kBaseIndex) return why_base_index_lost(file.name);
    if (file.kind != StoreFile::kBlockTables && file.kind != StoreFile::kLevel)
      return "nothing else in the store says what it held";
    if (check.depths_lost)
      return "the depths of the faces, which say where slots are, are damaged too";
    if (check.in_shards) return kMakeShardAgain;
    return file.kind == StoreFile::kLevel ? why_level_lost(file) : why_tables_lost(file);
  }

  /// For all files but levels. Returns false if the bytes are not those that the file had.
  bool write(const DamagedFile& file, std::span<const std::byte> bytes) {
    if (bytes.size() != file.expected_bytes || checksum_of(bytes) != file.expected_checksum)
      return false;
    File made(scratch.directory(), file.name, OpenMode::kCreate);
    made.write_at(0, bytes);
    made.close();
    return true;
  }

  void tell(const std::string& phase, std::uint64_t done, std::uint64_t total) {
    if (options.progress && !options.progress({phase, done, total}))
      throw Error(ErrorCode::kCancelled, fmt::format("repair {}: cancelled", path.native()));
  }

  std::optional<std::string> why_base_records_lost(const DamagedFile& file) {
    if (check.base.edge_count() == 0)
      return "base.mesh, from which they are made again, is damaged";
    const auto bytes = remaker.base_records(file.attribute);
    if (!bytes) return remaker.refusal();
    const AttributeSchema& schema = remaker.info_of(file.attribute).schema;
    if (!write(file, *bytes) &&
        !write(file, encode_base_records(schema, *bytes, check.base.positions())))
      return "what follows from the base mesh is not what it held";
    return std::nullopt;
  }

  std::optional<std::string> why_base_index_lost(const std::string& name) {
    if (check.base.edge_count() == 0) return "base.mesh, from which it is made again, is damaged";
    write_base_index_file(scratch.directory(), name, check.base, check.base_mesh_checksum, false);
    return std::nullopt;
  }

  /// Seals every block of every level.
  std::optional<std::string> why_tables_lost(const DamagedFile& file) {
    if (remaker.backend().traits.compressed)
      return "nothing else says where blocks are in a compressed level";
    if (check.base.edge_count() == 0) return "base.mesh is damaged too";
    const StoredVersion version(store, open_newest_version(store));
    std::vector<StoredLevel> levels = version.levels(check.base);
    std::vector<const BlockTable*> tables;
    bool is_known = true;
    for (StoredLevel& level : levels) {
      tell("seal blocks", tables.size(), levels.size());
      level.table = BlockTable(version.manifest().uuid, level.number, level.level,
                               level.geometry.block_count());
      is_known = is_known && !version.has_log();  // else it is not known which blocks it has
      for (std::uint64_t block = 0; is_known && block < level.geometry.block_count(); ++block) {
        const std::uint64_t offset = level.geometry.block_offset(block);
        const auto bytes = bytes_left(store, level.file_names().front(), offset,
                                      level.geometry.block_bytes(block));
        is_known = bytes.has_value();
        if (bytes) level.table.seal(block, offset, BlockEncoding::kRaw, *bytes);
      }
      tables.push_back(&level.table);
    }
    if (!is_known || !write(file, version.version_file_with(tables)))
      return "a level is damaged too, or has blocks in the change log or never written ones";
    return std::nullopt;
  }

  /// From the whole blocks of the file, and from made ones where a block is lost.
  std::optional<std::string> why_level_lost(const DamagedFile& file) {
    if (!file.expected_level)
      return "base mesh or block tables, which say what it held, are damaged too";
    LevelFile& level = *file.expected_level;
    const std::uint64_t bytes = repaired_bytes(level, remaker.backend().traits.compressed);
    // A forged table may put a block anywhere. No writer needs more: blocks of at most three
    // versions, none of them larger than raw, and gaps.
    const std::uint64_t most =
        4 * (level.geometry.total_bytes() + level.geometry.block_count() * kRepairPageBytes);
    if (bytes > most)
      return fmt::format("the block table wants a file of {} bytes, expected at most {}", bytes,
                         most);
    File made(scratch.directory(), file.name, OpenMode::kCreate);
    made.resize(bytes);
    std::uint64_t lost = 0;
    std::string why;
    for (std::uint64_t block = 0; block < level.table.size(); ++block) {
      tell("rebuild " + file.name, block, level.table.size());
      const BlockEntry& entry = level.table[block];
      if (entry.file != kLevelFile || entry.encoding == BlockEncoding::kNeverWritten ||
          entry.encoding == BlockEncoding::kPredicted)
        continue;  // no byte of it is in the file
      if (const auto left = bytes_left(store, file.name, entry.offset, entry.stored_bytes);
          left && level.table.matches(block, *left)) {
        made.write_at(entry.offset, *left);
      } else if (const auto again = remaker.block(file.attribute, level, block)) {
        made.write_at(entry.offset, *again);
      } else {
        ++lost;
        why = remaker.refusal();
      }
    }
    made.close();
    if (lost > 0) return fmt::format("{} of its {} blocks: {}", lost, level.table.size(), why);
    try {  // a file that the backend refuses must not replace the damaged one
      remaker.backend().open({})->open_level(
          {scratch.directory(), file.name, OpenMode::kRead, level.geometry, level.table,
           remaker.info_of(file.attribute).schema, level.pipeline});
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruption) throw;
      return fmt::format("what was made of it cannot be read: {}", error.what());
    }
    return std::nullopt;
  }
};

}  // namespace

void repair_files(const std::filesystem::path& store, const StoreCheck& check,
                  const RepairOptions& options, Remaker& remaker, UnpublishedDirectory& scratch,
                  RepairReport& report) {
  FileRepair repair{store, Directory(store), check, options, remaker, scratch};
  for (const DamagedFile& file : check.damaged) {
    if (const std::optional<std::string> why = repair.why_lost(file)) {
      if (scratch.made().is_open()) scratch.made().remove_if_possible(file.name);
      report.lost_files.push_back(
          {file.name, fmt::format("{}; it cannot be rebuilt: {}", file.reason, *why)});
      continue;
    }
    if (!options.dry_run) replace_file(store, check.sequence, file.name, scratch.directory());
    report.rebuilt_files.push_back({file.name, file.reason});
  }
  if (repair.store.contains(kBaseIndexName) || !wants_index(std::nullopt, check.base)) return;
  repair.why_base_index_lost(kBaseIndexName);
  if (!options.dry_run) replace_file(store, check.sequence, kBaseIndexName, scratch.directory());
  report.rebuilt_files.push_back({kBaseIndexName, "it is not there; opening is faster with it"});
}

void replace_file(const std::filesystem::path& path, std::uint64_t sequence,
                  const std::string& name, const Directory& from) {
  const Directory store = open_store_directory(path);
  const StoreLock lock = lock_for_writing(store, Durability::kCommit);
  // A reader locks the very file that may be replaced.
  const std::vector<File> alone = keep_all_readers_out(store);
  if (const std::uint64_t found = read_manifest(store).sequence; found != sequence)
    throw Error(ErrorCode::kBusy,
                fmt::format("replace {}: expected version {} of the store, found version {}",
                            store.path_of(name).native(), sequence, found));
  File file(from, name, OpenMode::kReadWrite);
  file.sync();
  file.close();
  from.rename(name, store, name);
  store.sync();
}

PLAIT_END_NAMESPACE
