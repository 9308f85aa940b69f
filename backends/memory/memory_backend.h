// backends/memory/memory_backend.h: a level as one anonymous mapping; gone with the process.
#pragma once

#include <memory>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kMemoryTraits{.in_memory = true};

/// Errors: kOutOfMemory; kBadState unless the mode is kCreate, for there is nothing to open.
std::unique_ptr<Backend> open_memory_backend(const LevelSpec& level);

}  // namespace plait
