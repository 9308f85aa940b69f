#include "plait/backends/pipeline.h"

#include <fmt/format.h>

#include "compressed/codecs/codec.h"
#include "compressed/filters/filter.h"
#include "plait/error.h"

namespace plait {

PipelineParts parse_pipeline(std::string_view pipeline) {
  if (pipeline == "none") return {};
  const auto refuse = [&](ErrorCode code, const std::string& expected) {
    constexpr std::size_t kMostNamed = 100;
    return Error(code, fmt::format("choose pipeline \"{}\": expected {}",
                                   pipeline.substr(0, kMostNamed), expected));
  };
  bool has_filter = false, has_codec = false;
  PipelineParts parts;
  for (std::string_view rest = pipeline;;) {
    const std::size_t end = rest.find(',');
    const std::string_view stage = rest.substr(0, end);
    if (!is_codec(stage) && !is_filter(stage))
      throw refuse(ErrorCode::kNotSupported,
                   fmt::format("stages of shuffle, lz4, zstd and zstd:LEVEL, or none alone, found "
                               "\"{}\"",
                               stage.substr(0, 20)));
    if (has_codec || (has_filter && is_filter(stage)))
      throw refuse(ErrorCode::kInvalidArgument, "one filter at most, then one codec at most");
    (is_codec(stage) ? has_codec : has_filter) = true;
    (is_codec(stage) ? parts.codec : parts.filter) = stage;
    if (end == std::string_view::npos) return parts;
    rest.remove_prefix(end + 1);
  }
}

std::string make_pipeline(const PipelineParts& parts) {
  if (parts.filter == "none") return parts.codec;
  return parts.codec == "none" ? parts.filter : parts.filter + ',' + parts.codec;
}

}  // namespace plait
