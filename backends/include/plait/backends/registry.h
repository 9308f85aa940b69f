// plait/backends/registry.h: the built-in backends.
#pragma once

#include "plait/backend.h"
#include "plait/backends/pipeline.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// memory, pread, uring, mmap and compressed. uring is in the list even if this machine cannot use
/// it. The registry is built once and is safe from any thread. To add your own backend, copy it.
const BackendRegistry& default_backends();

/// The same backends, but with these codecs and filters for `compressed`. Copies `pipelines`.
BackendRegistry default_backends(const PipelineRegistry& pipelines);

PLAIT_END_NAMESPACE
