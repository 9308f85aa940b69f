// backends/memory/memory_backend.h: keeps a level in one anonymous mapping. The level ends with the
// process.
#pragma once

#include <memory>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr BackendTraits kMemoryTraits{.in_memory = true};

/// Errors: kOutOfMemory; kBadState unless the mode is kCreate, because no level exists before.
std::unique_ptr<Backend> open_memory_backend(const LevelSpec& level);

PLAIT_END_NAMESPACE
