// backends/mmap/mmap_backend.h: a level as a shared mapping of its file (Boost.Interprocess); the
// operating system pages.
#pragma once

#include <memory>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kMmapTraits{.direct = true, .compressed = false, .durable = true};

/// Errors: as open_fixed_file; kIo where the file cannot be mapped. A new file is preallocated, so
/// that a full disk is an error here and not a SIGBUS at the first store into the mapping.
std::unique_ptr<Backend> open_mmap_backend(const LevelSpec& level);

}  // namespace plait
