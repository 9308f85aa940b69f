// backends/compressed/extent_allocator.h: keeps track of the free bytes of a level file.
//
//   | extent of a block | padding to kAlignmentBytes | free | extent | ...  end
//
// Invariants
//  1. Extents start at multiples of kAlignmentBytes and do not overlap.
//  2. Copy on write: when the extent of a block is replaced, it stays as it is while it belongs to
//     the newest version, to the version before that, or to a version that a reader has open. Then
//     it becomes free. An extent that belongs to no version becomes free at once.
//  3. Two free extents are never adjacent, and none is at the end of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "plait/extend/backend.h"
#include "plait/extend/block_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// One thread at a time.
class ExtentAllocator {
 public:
  static constexpr std::uint64_t kAlignmentBytes = 512;

  /// For a file of `file_bytes` that contains the blocks of `table`, and the blocks of the older
  /// versions `held`. The bytes between the blocks are free.
  /// Errors: kCorruption naming `file` and the block, for an extent that is misaligned, empty,
  /// outside the file or overlapping another one. Several versions may have the same extent for
  /// the same block.
  ExtentAllocator(std::span<const BlockEntry> table, std::uint64_t file_bytes,
                  const std::filesystem::path& file, std::span<const HeldTable> held = {});

  /// Adds `count` blocks without an extent, of another level in the file. Returns the number of the
  /// first one.
  std::uint64_t add_blocks(std::uint64_t count);

  /// Allocates `bytes` bytes and returns their offset. Takes the smallest free extent that is large
  /// enough, or else the end of the file.
  /// REQUIRES: bytes > 0.
  std::uint64_t allocate(std::uint64_t bytes);

  /// Frees an extent from allocate() that no block uses.
  void release(std::uint64_t offset, std::uint64_t bytes);

  /// `block` has a new extent. Frees its former extent `former`, as soon as invariant 2 allows it.
  void replace(std::uint64_t block, const BlockEntry& former);

  /// Version `sequence` was committed, with the extents that the blocks have now. Readers have the
  /// older versions `held` open, in ascending order. Frees what invariant 2 allows.
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held);

  /// The bytes that the extents of these blocks take.
  static std::uint64_t bytes_of(std::span<const BlockEntry> table);

  /// One past the last byte in use, a multiple of kAlignmentBytes.
  std::uint64_t end_bytes() const { return end_bytes_; }

 private:
  static constexpr std::uint64_t kNoVersion = ~std::uint64_t{0};

  /// An extent that versions `first` to `last` have, and no later one. `last` is kNoVersion until
  /// the version is known in which the extent was replaced.
  struct Retired {
    std::uint64_t offset, bytes, first, last;
  };

  void insert_free(std::uint64_t offset, std::uint64_t bytes);
  void erase_free(std::map<std::uint64_t, std::uint64_t>::iterator extent);

  std::map<std::uint64_t, std::uint64_t> free_;                      ///< offset to bytes
  std::set<std::pair<std::uint64_t, std::uint64_t>> free_by_bytes_;  ///< (bytes, offset)
  /// [block] the first version that has the block's extent; kNoVersion if none has it yet.
  std::vector<std::uint64_t> first_version_;
  std::vector<Retired> retired_;
  std::uint64_t end_bytes_ = 0;
};

PLAIT_END_NAMESPACE
