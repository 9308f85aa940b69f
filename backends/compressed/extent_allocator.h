// backends/compressed/extent_allocator.h: which bytes of a level file are free.
//
//   | extent of a block | padding to kAlignmentBytes | free | extent | ...  end
//
// Invariants
//  1. Extents start at multiples of kAlignmentBytes and do not overlap.
//  2. Copy on write: extents that the table had when the file was opened, or at a hold(), belong to
//     a version that may be the last one published. They are given out again after the second
//     hold() from their replacement on: by the first the next version is on its way, by the second
//     it is there. Those given out since the last hold() are free as soon as they are released.
//  3. Free extents never touch each other nor the end.
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

  /// For a file of `file_bytes` that holds the blocks of `table`. What lies between them is free.
  /// Errors: kCorruption naming `file` and the block for an extent that is misaligned, empty,
  /// beyond the file or in another one.
  ExtentAllocator(std::span<const BlockEntry> table, std::uint64_t file_bytes,
                  const std::filesystem::path& file);

  /// Offset of `bytes` free bytes: the smallest free extent that has them, or the end.
  /// REQUIRES: bytes > 0.
  std::uint64_t allocate(std::uint64_t bytes);

  /// Gives back an extent of `allocate` that no block got.
  void release(std::uint64_t offset, std::uint64_t bytes);

  /// `block` has got another extent than `former`, which is released if invariant 2 allows it.
  void replace(std::uint64_t block, const BlockEntry& former);

  /// The table is that of a version that is about to be published.
  void hold(std::span<const BlockEntry> table);

  /// One past the last byte in use, a multiple of kAlignmentBytes.
  std::uint64_t end_bytes() const { return end_bytes_; }

 private:
  void insert_free(std::uint64_t offset, std::uint64_t bytes);
  void erase_free(std::map<std::uint64_t, std::uint64_t>::iterator extent);

  std::map<std::uint64_t, std::uint64_t> free_;                      ///< offset to bytes
  std::set<std::pair<std::uint64_t, std::uint64_t>> free_by_bytes_;  ///< (bytes, offset)
  std::vector<bool> held_;  ///< [block] its extent is of a version
  /// Extents of versions, replaced since the last hold(), and between that and the one before.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> replaced_, replaced_before_;
  std::uint64_t end_bytes_ = 0;
};

}  // namespace plait
