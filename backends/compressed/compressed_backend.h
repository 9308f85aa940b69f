// backends/compressed/compressed_backend.h: every block through a pipeline, in an extent of its own
// size. The level file is nothing but these extents, in the order in which they
// were written; the block table says where they are.
#pragma once

#include "plait/backend.h"
#include "plait/backends/pipeline.h"

namespace plait {

constexpr BackendTraits kCompressedTraits{.durable = true, .compressed = true};

/// The entry of a registry. Errors of a level: as ExtentAllocator and PipelineRegistry::make;
/// kCorruption for an entry that cannot be of its block; kInvalidArgument if a block is larger than
/// LZ4_MAX_INPUT_SIZE.
BackendRegistry::Entry compressed_backend(const PipelineRegistry& pipelines);

}  // namespace plait
