// The file version.S describes version S: a header, the description, and the block tables of all
// levels, one after another. Byte table: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "plait/error.h"
#include "plait/extend/block_table.h"
#include "plait/extend/file.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The bytes of the file. `description` is the result of encode_description(). The tables are those
/// of all levels, with attributes in the description's order and levels ascending.
std::vector<std::byte> encode_version_file(std::span<const std::byte> description,
                                           std::span<const BlockTable* const> tables);

/// Reads the bytes of the description. Does not trust sizes in the file: it allocates at most the
/// size of the file. Errors: kCorruption for a wrong header, size or checksum; kIo.
std::vector<std::byte> read_description(const File& file);

/// The offset of the block tables in the file.
constexpr std::uint64_t block_tables_offset(std::size_t description_bytes) {
  return 32 + description_bytes;
}

/// Reads the entries of one level after another from the bytes of all block tables. Does not trust
/// the geometry: it allocates at most the size of these bytes.
class BlockTablesReader {
 public:
  /// `bytes` must outlive this object; `path` is for messages.
  BlockTablesReader(std::span<const std::byte> bytes, std::filesystem::path path);

  /// Reads the entries of the next level. The store's change log has `log_bytes` bytes. Errors:
  /// kCorruption for an entry out of its range, or too few entries.
  std::vector<BlockEntry> next_level(const LevelGeometry& geometry, std::uint64_t log_bytes = 0);

  /// Throws kCorruption if there are bytes after the last level.
  void finish() const;

 private:
  Error refuse(std::string_view reason) const;

  std::span<const std::byte> rest_;
  std::filesystem::path path_;
};

PLAIT_END_NAMESPACE
