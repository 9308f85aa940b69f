// backends/uring/uring_backend.h: a level as a file of raw bytes, which io_uring reads and writes
// past the page cache (O_DIRECT). The file is the same as with pread and mmap, byte for byte.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/backend.h"

PLAIT_BEGIN_NAMESPACE

constexpr BackendTraits kUringTraits{.durable = true, .overwrites_in_place = true};

/// All levels share one ring, and the page buffers for blocks whose memory is not aligned for
/// O_DIRECT. A new file is preallocated.
/// Where the kernel refuses io_uring, or plait was built without it, pread stands in; where the
/// file system has no O_DIRECT, blocks go through the page cache: TellingVolume::notices() says so.
/// open_level() throws as open_fixed_file does.
std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume);

/// Throws kNotSupported if plait was built without liburing, or if the kernel refuses io_uring.
void check_uring();

PLAIT_END_NAMESPACE
