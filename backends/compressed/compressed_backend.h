// backends/compressed/compressed_backend.h: every block through a filter chain and a codec, in an
// extent of its own size. The level file is nothing but these extents, in the order in which they
// were written; the block table says where they are.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backend.h"

namespace plait {

constexpr BackendTraits kCompressedTraits{.durable = true, .compressed = true};

/// Errors of opening a level: as ExtentAllocator and BlockCoder; kCorruption for an entry that
/// cannot be of its block; kInvalidArgument if a block is larger than LZ4_MAX_INPUT_SIZE.
std::unique_ptr<Volume> open_compressed_volume(const VolumeSpec& volume);

/// Refuses a pipeline with a stage that is not there. Errors: as BlockCoder.
void validate_pipeline(std::string_view pipeline);

}  // namespace plait
