// plait/block_table.h: for every block of one level of one attribute: where its stored bytes are,
// how they are encoded, and their checksum.
//
// The checksum is XXH3-64 of the stored bytes, seeded by the block's identity (store, attribute,
// level, block number), so that a flipped bit, a torn and a misplaced block are all found.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "plait/topology.h"

namespace plait {

using StoreUuid = std::array<std::byte, 16>;

/// Stored: never renumber.
enum class BlockEncoding : std::uint32_t {
  kNeverWritten = 0,  ///< reads as zeros
  kRaw = 1,
  kEncoded = 2,  ///< by the pipeline of its level
};

/// Stored as it is: see docs/format.md, "Block tables".
struct BlockEntry {
  std::uint64_t offset = 0;        ///< in the level file, bytes
  std::uint32_t stored_bytes = 0;  ///< on disk
  BlockEncoding encoding = BlockEncoding::kNeverWritten;
  std::uint64_t checksum = 0;
};
static_assert(sizeof(BlockEntry) == 24);

/// One writer of an entry at a time; different entries may be set from different threads.
class BlockTable {
 public:
  BlockTable() = default;
  BlockTable(const StoreUuid& store, std::uint32_t attribute, int level, std::uint64_t blocks);

  std::uint32_t attribute() const { return attribute_; }
  int level() const { return level_; }
  std::uint64_t size() const { return entries_.size(); }
  const BlockEntry& operator[](std::uint64_t block) const { return entries_[block]; }
  std::span<const BlockEntry> entries() const { return entries_; }
  std::span<BlockEntry> entries() { return entries_; }

  /// Enters a block whose stored bytes are `stored`, with their checksum.
  void seal(std::uint64_t block, std::uint64_t offset, BlockEncoding encoding,
            std::span<const std::byte> stored);
  /// Enters a raw block without a checksum: for levels that never leave memory.
  void mark_written(std::uint64_t block, std::uint64_t offset, std::uint64_t bytes);
  /// Whether `stored` is what was sealed.
  bool matches(std::uint64_t block, std::span<const std::byte> stored) const;
  /// Errors: kCorruption naming `file`, level, block and offset, both checksums.
  void check(std::uint64_t block, std::span<const std::byte> stored,
             const std::filesystem::path& file) const;

 private:
  std::uint64_t checksum(std::uint64_t block, std::span<const std::byte> stored) const;

  std::uint64_t seed_ = 0;
  std::uint32_t attribute_ = 0;
  int level_ = 0;
  std::vector<BlockEntry> entries_;
};

}  // namespace plait
