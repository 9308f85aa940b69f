// Copies bytes of one file to the same offset of another file. The system copies them without
// moving them through the memory of the process, if it can. On file systems that share extents
// (btrfs, xfs) it copies no data at all. Likewise a whole file gets a second name instead of a
// copy.
#pragma once

#include <cstdint>
#include <string>

#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls the hook of io/file_operations.h for a read and for a write. Errors: kIo, kNoSpace;
/// kCorruption if `from` ends before the last byte.
void copy_range(const File& from, File& to, std::uint64_t offset, std::uint64_t bytes);

/// Gives the file `name` of `directory` the same name in `other`, on the same file system. Errors:
/// kNotSupported on a file system without hard links; kIo, kNoSpace.
void link_file(const Directory& directory, const std::string& name, const Directory& other);

PLAIT_END_NAMESPACE
