#include "maintenance/tables_from_levels.h"

#include <string>

#include "format/checksum.h"
#include "plait/error.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Seals all blocks of a level; false if its file does not hold them.
bool seal_level(const Directory& store, const std::string& name, const LevelGeometry& geometry,
                BlockTable& table) {
  std::vector<std::byte> buffer(geometry.max_block_bytes());
  try {
    const File file(store, name, OpenMode::kRead);
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
      const std::span<std::byte> bytes = std::span(buffer).first(geometry.block_bytes(block));
      file.read_at(geometry.block_offset(block), bytes);
      table.seal(block, geometry.block_offset(block), BlockEncoding::kRaw, bytes);
    }
    return true;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound) throw;
    return false;
  }
}

}  // namespace

std::optional<std::vector<std::byte>> tables_from_levels(const std::filesystem::path& path,
                                                         const StoreCheck& check,
                                                         const ProgressCallback& progress) {
  const Directory store(path);
  const StoredVersion version(store, open_newest_version(store));
  std::vector<StoredLevel> levels = version.levels(check.base);
  std::vector<const BlockTable*> tables;
  for (StoredLevel& level : levels) {
    if (progress && !progress({"seal blocks", tables.size(), levels.size()}))
      throw Error(ErrorCode::kCancelled, "make block tables: cancelled");
    level.table = BlockTable(version.manifest().uuid, level.number, level.level,
                             level.geometry.block_count());
    const std::vector<std::string> files = level.file_names();
    if (files.size() > 1) return std::nullopt;  // nothing else says which file has a block
    if (!seal_level(store, files.front(), level.geometry, level.table)) return std::nullopt;
    tables.push_back(&level.table);
  }
  std::vector<std::byte> bytes = version.version_file_with(tables);
  if (bytes.size() != version.manifest().version_bytes ||
      checksum_of(bytes) != version.manifest().version_checksum)
    return std::nullopt;
  return bytes;
}

PLAIT_END_NAMESPACE
