// tables.S: the block tables of every level of one version, one after another. Byte table:
// docs/format.md.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "plait/block_table.h"
#include "plait/error.h"
#include "plait/level_geometry.h"

namespace plait {

/// The file's bytes for the tables of all levels: attributes in manifest order, levels ascending.
std::vector<std::byte> encode_tables(std::span<const BlockTable* const> tables);

/// Takes the entries of one level after another from the bytes of a whole file. Nothing is
/// believed: memory stays below that of the bytes, whatever a geometry promises.
class BlockTablesReader {
 public:
  /// `bytes` must outlive this object; `path` is for messages.
  /// Errors: kCorruption for a wrong header.
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
