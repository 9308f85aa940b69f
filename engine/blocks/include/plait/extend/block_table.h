// plait/extend/block_table.h: the table of the blocks of one level of one attribute. An entry says
// in which of the level's files the stored bytes of a block are, and where, how they are encoded,
// and what their checksum is.
//
// The checksum is XXH3-64 of the stored bytes, seeded by the block's identity (store, attribute,
// level, block number). So it detects a flipped bit, a block that was written in part, and a block
// at the wrong place.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

using StoreUuid = std::array<std::byte, 16>;

/// Stored: never renumber.
enum class BlockEncoding : std::uint16_t {
  kNeverWritten = 0,  ///< reads as zeros
  kRaw = 1,
  kEncoded = 2,    ///< by the pipeline of its level
  kPredicted = 3,  ///< in no bytes: made again when it is read (plait/extend/block_maker.h)
};

/// Files contain this struct byte for byte: see docs/format.md, "Block tables".
struct BlockEntry {
  std::uint64_t offset = 0;        ///< in its file, bytes
  std::uint32_t stored_bytes = 0;  ///< on disk
  BlockEncoding encoding = BlockEncoding::kNeverWritten;
  std::uint16_t file = 0;      ///< position in BlockTable::generations()
  std::uint64_t checksum = 0;  ///< of the stored bytes; of a predicted block's raw bytes
};
static_assert(sizeof(BlockEntry) == 24);

/// A file of a level, named by the version that made it.
struct Generation {
  std::uint64_t version = 0;
  /// The number of blocks that were written to a sparse file. 0 for the first file of a level,
  /// which has room for all blocks.
  std::uint64_t blocks = 0;

  friend bool operator==(const Generation&, const Generation&) = default;
};

/// A level has at most so many sparse files beside its first file.
inline constexpr std::size_t kMostSparseFiles = 7;

/// Only one thread at a time may set an entry; several threads may set different entries.
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

  /// The files of the level, with ascending versions. Empty for a level in memory. The store sets
  /// them; a backend writes and reads one file, and does not use them.
  std::span<const Generation> generations() const { return generations_; }
  void set_generations(std::vector<Generation> generations) {
    generations_ = std::move(generations);
  }

  /// Sets the entry of a block whose stored bytes are `stored`, and computes their checksum. The
  /// entry's file becomes 0.
  void seal(std::uint64_t block, std::uint64_t offset, BlockEncoding encoding,
            std::span<const std::byte> stored);
  /// Sets the entry of a predicted block whose bytes are `raw`.
  void seal_predicted(std::uint64_t block, std::span<const std::byte> raw);
  /// Sets the entry of a raw block without a checksum, for levels in memory.
  void mark_written(std::uint64_t block, std::uint64_t offset, std::uint64_t bytes);
  /// Whether the size and the checksum of `stored` are those of the sealed block. For a predicted
  /// block, `stored` are its raw bytes.
  bool matches(std::uint64_t block, std::span<const std::byte> stored) const;
  /// Throws kCorruption unless matches(). The message names `file`, level, block, offset and both
  /// checksums.
  void check(std::uint64_t block, std::span<const std::byte> stored,
             const std::filesystem::path& file) const;

 private:
  std::uint64_t checksum(std::uint64_t block, std::span<const std::byte> stored) const;

  std::uint64_t seed_ = 0;
  std::uint32_t attribute_ = 0;
  int level_ = 0;
  std::vector<BlockEntry> entries_;
  std::vector<Generation> generations_;
};

PLAIT_END_NAMESPACE
