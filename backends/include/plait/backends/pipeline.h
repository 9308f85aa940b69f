// plait/backends/pipeline.h: how the backend "compressed" encodes a block, as text: filters in the
// order of encoding, then at most one codec, separated by commas, such as "shuffle,zstd:1". What
// follows a colon is the stage's own option. "none" is the pipeline without a stage.
#pragma once

#include <string>
#include <string_view>

namespace plait {

/// Each part is "none" where the pipeline has no such stage.
struct PipelineParts {
  std::string filter = "none";  ///< "shuffle"
  std::string codec = "none";   ///< "lz4", "zstd", "zstd:LEVEL"

  friend bool operator==(const PipelineParts&, const PipelineParts&) = default;
};

/// Errors: kNotSupported naming the stages there are; kInvalidArgument for a second filter, and for
/// a stage behind the codec. The codec's option is not looked at.
PipelineParts parse_pipeline(std::string_view pipeline);

/// parse_pipeline() gives the parts again. Pinned by tests/backends/compressed/pipeline_test.cpp.
std::string make_pipeline(const PipelineParts& parts);

}  // namespace plait
