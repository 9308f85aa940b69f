// version.S: what version S consists of: a header, the description, and the block tables of every
// level one after another. Byte table: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "plait/block_table.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/level_geometry.h"

namespace plait {

/// The file's bytes: `description` as encode_description gives it, tables of all levels with
/// attributes in the description's order and levels ascending.
std::vector<std::byte> encode_version_file(std::span<const std::byte> description,
                                           std::span<const BlockTable* const> tables);

/// The description's bytes. Nothing is believed: memory stays below that of the file.
/// Errors: kCorruption for a wrong header, size or checksum; kIo.
std::vector<std::byte> read_description(const File& file);

/// Where the block tables begin behind a description of so many bytes.
constexpr std::uint64_t block_tables_offset(std::size_t description_bytes) {
  return 32 + description_bytes;
}

/// Takes the entries of one level after another from the bytes of all block tables. Nothing is
/// believed: memory stays below that of the bytes, whatever a geometry promises.
class BlockTablesReader {
 public:
  /// `bytes` must outlive this object; `path` is for messages.
  BlockTablesReader(std::span<const std::byte> bytes, std::filesystem::path path);

  /// The entries of the next level, each in its range.
  /// Errors: kCorruption for an entry out of range, or too few of them.
  std::vector<BlockEntry> next_level(const LevelGeometry& geometry);

  /// Errors: kCorruption if there are bytes behind the last level.
  void finish() const;

 private:
  Error refuse(std::string_view reason) const;

  std::span<const std::byte> rest_;
  std::filesystem::path path_;
};

}  // namespace plait
