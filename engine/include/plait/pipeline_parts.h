// plait/pipeline_parts.h: a pipeline split into the values of the options --filter and --codec.
#pragma once

#include <string>
#include <string_view>

#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// The text before and after the first comma of a pipeline; plait/backends/pipeline.h has the
/// grammar.
struct PipelineParts {
  std::string filter = "none", codec = "none";

  /// The parts of "" are those of "none".
  static PipelineParts of(std::string_view pipeline) {
    if (pipeline.empty()) return {};
    const std::size_t comma = pipeline.find(',');
    if (comma == std::string_view::npos) return {"none", std::string(pipeline)};
    return {std::string(pipeline.substr(0, comma)), std::string(pipeline.substr(comma + 1))};
  }
  std::string pipeline() const { return filter == "none" ? codec : filter + ',' + codec; }
};

PLAIT_END_NAMESPACE
