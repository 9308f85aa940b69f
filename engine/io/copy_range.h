// Bytes of one file copied to the same place of another, by the system where it can do so without
// moving them through memory: file systems that share extents (btrfs, xfs) copy nothing at all.
#pragma once

#include <cstdint>

#include "plait/file.h"

namespace plait {

/// Passes the seam of plait/file_operations.h as a read and a write.
/// Errors: kIo, kNoSpace; kCorruption where `from` ends before the last byte.
void copy_range(const File& from, File& to, std::uint64_t offset, std::uint64_t bytes);

}  // namespace plait
