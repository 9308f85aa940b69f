// The blocks of a level in memory as the last commit had them. A level in a file has the committed
// bytes in the file; a level in memory is changed in place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "plait/detail/level_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Keeps the bytes of each block from its first change after a commit. Threads: keep() is shared.
class KeptBlocks {
 public:
  /// For a level whose present content is committed. Errors: std::bad_alloc.
  explicit KeptBlocks(const LevelFile& level);

  /// To be called before a block is changed. Errors: std::bad_alloc.
  void keep(LevelFile& level, std::uint64_t block);
  /// Gives the level its committed content.
  void restore(LevelFile& level) noexcept;

 private:
  struct Kept {
    std::uint64_t block;
    std::vector<std::byte> bytes;
  };
  const std::vector<BlockEntry> entries_;
  std::mutex mutex_;  ///< for the following
  std::vector<bool> is_kept_;
  std::vector<Kept> kept_;
};

PLAIT_END_NAMESPACE
