// backends/uring/uring_backend.h: a level as a file of raw bytes, moved by io_uring past the page
// cache (O_DIRECT). The file is that of pread and mmap, byte for byte.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kUringTraits{.durable = true, .overwrites_in_place = true};

/// Its levels share one ring, and the buffers for blocks whose memory O_DIRECT does not take.
/// Errors: as validate_uring. Of a level: as open_fixed_file;
/// kNotSupported naming the file where its file system has no O_DIRECT. A new file is preallocated.
std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume);

/// Errors: kInvalidArgument for any option; kNotSupported where liburing was absent when this was
/// built, or the kernel refuses io_uring.
void validate_uring(std::string_view options);

}  // namespace plait
