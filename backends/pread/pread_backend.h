// backends/pread/pread_backend.h: a level as a file of raw bytes, moved by explicit reads and
// writes: the paper's circular buffer when the pager's frames go round.
#pragma once

#include <memory>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kPreadTraits{.durable = true, .overwrites_in_place = true};

/// Errors: as open_fixed_file. A new file has its space from the start.
std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level);

}  // namespace plait
