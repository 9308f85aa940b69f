// plait/backends/registry.h: the built-in backends.
#pragma once

#include "plait/backend.h"

namespace plait {

/// memory, pread, mmap and compressed. Built once; safe from any thread; add your own to a copy.
const BackendRegistry& default_backends();

}  // namespace plait
