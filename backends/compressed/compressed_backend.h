// backends/compressed/compressed_backend.h: stores each block filtered and compressed, in an extent
// as long as the result. A level file consists of such extents, in the order in which they were
// written. The block table has their places.
#pragma once

#include <memory>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kCompressedTraits{.durable = true, .compressed = true};

/// Errors: as ExtentAllocator, make_codec and make_filter_chain; kCorruption for a table entry that
/// its block cannot have; kInvalidArgument if a block is larger than LZ4_MAX_INPUT_SIZE.
std::unique_ptr<Volume> open_compressed_volume(const VolumeSpec& volume);

/// Throws unless the codec and the filter exist. Errors: as make_codec and make_filter_chain.
void validate_compressed_options(const BackendOptions& options);

}  // namespace plait
