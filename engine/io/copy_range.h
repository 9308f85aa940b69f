// Copies bytes of one file to the same offset of another file. The system copies them without
// moving them through the memory of the process, if it can. On file systems that share extents
// (btrfs, xfs) it copies no data at all.
#pragma once

#include <cstdint>

#include "plait/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls the hook of plait/file_operations.h for a read and for a write. Errors: kIo, kNoSpace;
/// kCorruption if `from` ends before the last byte.
void copy_range(const File& from, File& to, std::uint64_t offset, std::uint64_t bytes);

PLAIT_END_NAMESPACE
