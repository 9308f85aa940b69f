// backends/compressed/extent_allocator.h: keeps track of the free bytes of a level file.
//
//   | extent of a block | padding to kAlignmentBytes | free | extent | ...  end
//
// Invariants
//  1. Extents start at multiples of kAlignmentBytes and do not overlap.
//  2. Copy on write: a published version may have an extent that the table had when the file was
//     opened, or at a hold(). When such an extent is replaced, it becomes free only at the second
//     hold() after that: the first hold() begins the commit of a version without the extent, and
//     the second one shows that this commit is done. An extent that was allocated after the last
//     hold() becomes free as soon as it is released.
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

#include "plait/block_table.h"

namespace plait {

/// One thread at a time.
class ExtentAllocator {
 public:
  static constexpr std::uint64_t kAlignmentBytes = 512;

  /// For a file of `file_bytes` that contains the blocks of `table`. The bytes between the blocks
  /// are free.
  /// Errors: kCorruption naming `file` and the block, for an extent that is misaligned, empty,
  /// outside the file or overlapping another one.
  ExtentAllocator(std::span<const BlockEntry> table, std::uint64_t file_bytes,
                  const std::filesystem::path& file);

  /// Allocates `bytes` bytes and returns their offset. Takes the smallest free extent that is large
  /// enough, or else the end of the file.
  /// REQUIRES: bytes > 0.
  std::uint64_t allocate(std::uint64_t bytes);

  /// Frees an extent from allocate() that no block uses.
  void release(std::uint64_t offset, std::uint64_t bytes);

  /// `block` has a new extent. Frees its former extent `former`, as soon as invariant 2 allows it.
  void replace(std::uint64_t block, const BlockEntry& former);

  /// Called before a commit: `table` is the table of the version that will be published.
  void hold(std::span<const BlockEntry> table);

  /// One past the last byte in use, a multiple of kAlignmentBytes.
  std::uint64_t end_bytes() const { return end_bytes_; }

 private:
  void insert_free(std::uint64_t offset, std::uint64_t bytes);
  void erase_free(std::map<std::uint64_t, std::uint64_t>::iterator extent);

  std::map<std::uint64_t, std::uint64_t> free_;                      ///< offset to bytes
  std::set<std::pair<std::uint64_t, std::uint64_t>> free_by_bytes_;  ///< (bytes, offset)
  std::vector<bool> held_;  ///< [block] whether a version has its extent
  /// Extents that a version has and that were replaced: since the last hold(); between the last
  /// hold() and the one before it.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> replaced_, replaced_before_;
  std::uint64_t end_bytes_ = 0;
};

}  // namespace plait
