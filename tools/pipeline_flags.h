// tools/pipeline_flags.h: --codec and --filter, which together are the pipeline of a store.
#pragma once

#include <string>
#include <string_view>

namespace plait {

/// See plait/backends/pipeline.h.
struct PipelineFlags {
  std::string filter = "none", codec = "none";

  /// The parts of a pipeline.
  static PipelineFlags of(std::string_view pipeline) {
    const std::size_t comma = pipeline.find(',');
    if (comma == std::string_view::npos) return {"none", std::string(pipeline)};
    return {std::string(pipeline.substr(0, comma)), std::string(pipeline.substr(comma + 1))};
  }
  std::string pipeline() const { return filter == "none" ? codec : filter + ',' + codec; }
};

}  // namespace plait
