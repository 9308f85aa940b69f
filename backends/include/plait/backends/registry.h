// plait/backends/registry.h: the built-in backends.
#pragma once

#include "plait/backend.h"
#include "plait/backends/pipeline.h"

namespace plait {

/// memory, pread, uring, mmap and compressed. uring is in the list even where it cannot be had.
/// Built once; safe from any thread; add your own to a copy.
const BackendRegistry& default_backends();

/// The same backends, where `compressed` knows these codecs and filters. Copies `pipelines`.
BackendRegistry default_backends(const PipelineRegistry& pipelines);

}  // namespace plait
