// plait/registry.h: the built-in backends, filters and codecs.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pipeline_registry.h"

PLAIT_BEGIN_NAMESPACE

/// memory, pread, uring, mmap and compressed. uring is in the list even if this machine cannot use
/// it. The registry is built once and is safe from any thread. To add your own backend, copy it.
const BackendRegistry& default_backends();

/// The same backends, but with these codecs and filters for `compressed`. Copies `pipelines`.
BackendRegistry default_backends(const PipelineRegistry& pipelines);

/// The codecs and filters of docs/format.md. Built once; safe from any thread.
const PipelineRegistry& default_pipelines();

PLAIT_END_NAMESPACE
