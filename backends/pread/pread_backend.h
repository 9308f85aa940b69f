// backends/pread/pread_backend.h: a level as a file of raw bytes, with explicit reads and writes.
// When the pager recycles frames first-in first-out, this is the circular buffer of Guskov's paper.
#pragma once

#include <memory>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr BackendTraits kPreadTraits{.durable = true, .overwrites_in_place = true};

/// The space of a new file is allocated when the file is created. Errors: as open_fixed_file.
std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level);

PLAIT_END_NAMESPACE
