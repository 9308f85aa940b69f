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
#include <memory>
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
  std::uint16_t file = 0;      ///< kLevelFile or kLogFile
  std::uint64_t checksum = 0;  ///< of the stored bytes; of a predicted block's raw bytes
};
static_assert(sizeof(BlockEntry) == 24);

/// Where the stored bytes of a block are: in the level's own file, or in the store's change log
/// (docs/format.md). Stored: never renumber.
inline constexpr std::uint16_t kLevelFile = 0, kLogFile = 1;

/// The entries of a table that is read from the disk part by part, when they are asked for. Safe
/// from several threads.
class StoredEntries {
 public:
  virtual ~StoredEntries() = default;
  virtual std::uint64_t size() const noexcept = 0;
  /// Errors: kCorruption, kNotFound and kIo of the part that has the entry.
  virtual const BlockEntry& at(std::uint64_t block) = 0;
  /// All entries. Errors: as at(), of all parts.
  virtual std::span<BlockEntry> all() = 0;
};

/// Only one thread at a time may set an entry; several threads may set different entries.
class BlockTable {
 public:
  BlockTable() = default;
  /// A table of blocks that the store numbers from `first_number` on: it is not 0 if the table is
  /// that of one shard.
  BlockTable(const StoreUuid& store, std::uint32_t attribute, int level, std::uint64_t blocks,
             std::uint64_t first_number = 0);
  /// A table that nobody changes, whose entries are read when they are asked for: operator[],
  /// entries(), matches() and check() then have the errors of StoredEntries.
  BlockTable(const StoreUuid& store, std::uint32_t attribute, int level,
             std::shared_ptr<StoredEntries> stored);

  /// A copy of the `count` entries from `first` on, whose blocks the store numbers as before, for
  /// one shard alone.
  BlockTable part(std::uint64_t first, std::uint64_t count) const;

  std::uint32_t attribute() const { return attribute_; }
  int level() const { return level_; }
  std::uint64_t size() const { return stored_ ? stored_->size() : entries_.size(); }
  const BlockEntry& operator[](std::uint64_t block) const {
    return stored_ ? stored_->at(block) : entries_[block];
  }
  std::span<const BlockEntry> entries() const {
    return stored_ ? std::span<const BlockEntry>(stored_->all()) : entries_;
  }
  /// Whether the block may have been written. Reads no entry, so it has no errors.
  bool may_be_written(std::uint64_t block) const noexcept {
    return stored_ || entries_[block].encoding != BlockEncoding::kNeverWritten;
  }
  std::span<BlockEntry> entries() { return stored_ ? stored_->all() : entries_; }

  /// The version that made the level's file. 0 for a level in memory. The store sets it; a backend
  /// does not use it.
  std::uint64_t generation() const { return generation_; }
  void set_generation(std::uint64_t generation) { generation_ = generation; }

  /// Sets the entry of a block whose stored bytes are `stored`, and computes their checksum. The
  /// entry's file becomes kLevelFile.
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

  std::uint64_t seed_ = 0, first_number_ = 0;
  std::uint32_t attribute_ = 0;
  int level_ = 0;
  std::vector<BlockEntry> entries_;
  std::shared_ptr<StoredEntries> stored_;
  std::uint64_t generation_ = 0;
};

PLAIT_END_NAMESPACE
