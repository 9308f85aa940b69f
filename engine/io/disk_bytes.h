// io/disk_bytes.h: how much of a file is on the disk. A sparse file costs nothing and can be of any
// size, so its size is no reason to spend time or memory on it.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The bytes of the file that are not in holes (SEEK_DATA), all of them where the file system does
/// not know holes. Stops to count at `enough`, and may return more.
std::uint64_t bytes_on_disk(const File& file, std::uint64_t enough);

PLAIT_END_NAMESPACE
