// plait/backends/registry.h: the built-in backends.
#pragma once

#include "plait/backend.h"

namespace plait {

/// memory, pread, uring, mmap and compressed. uring is in the list even where it cannot be had.
/// Built once; safe from any thread; add your own to a copy.
const BackendRegistry& default_backends();

}  // namespace plait
