#include <cstring>
#include <utility>

#include "plait/error.h"
#include "plait/structure.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/manifest.h"
#include "store/stored_geometry.h"

namespace plait {
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

std::optional<std::vector<std::byte>> tables_from_levels(
    const std::filesystem::path& path, const StoreStructure& structure,
    const std::function<bool(std::uint64_t, std::uint64_t)>& proceed) {
  const Directory store(path);
  const Manifest manifest = read_manifest(store);
  std::uint64_t levels = 0, done = 0;
  for (const ManifestAttribute& attribute : manifest.attributes)
    levels += static_cast<std::uint64_t>(attribute.finest_level - manifest.base_level);

  // docs/format.md, "tables.S".
  std::vector<std::byte> bytes(16);
  std::memcpy(bytes.data(), "plaitblk", 8);
  save(std::span(bytes), 8, std::uint32_t{1});
  for (const ManifestAttribute& attribute : manifest.attributes)
    for (int level = manifest.base_level + 1; level <= attribute.finest_level; ++level) {
      if (proceed && !proceed(done++, levels))
        throw Error(ErrorCode::kCancelled, "make block tables: cancelled");
      const LevelGeometry geometry =
          stored_geometry(manifest, structure.base, attribute, level, store.path_of(kManifestName));
      BlockTable table(manifest.uuid, attribute.number, level, geometry.block_count());
      if (!seal_level(store, level_file_name(attribute.number, level), geometry, table))
        return std::nullopt;
      const auto entries = std::as_bytes(std::as_const(table).entries());
      bytes.insert(bytes.end(), entries.begin(), entries.end());
    }
  if (bytes.size() != manifest.tables_bytes || checksum_of(bytes) != manifest.tables_checksum)
    return std::nullopt;
  return bytes;
}

}  // namespace plait
