// backends/compressed/compressed_backend.h: encodes each block with a pipeline and stores it in an
// extent as long as the result. A level file consists of such extents, in the order in which they
// were written. The block table has their places. The levels of a store share coders.
#pragma once

#include "plait/extend/backend_registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr BackendTraits kCompressedTraits{.durable = true, .compressed = true};

/// Errors of a level: as ExtentAllocator and PipelineRegistry::open(); kCorruption for a table
/// entry that its block cannot have; kInvalidArgument if a block is larger than LZ4_MAX_INPUT_SIZE.
RegisteredBackend compressed_backend(const PipelineRegistry& stages);

PLAIT_END_NAMESPACE
