// The text of a pipeline, of pipelines for ranges of levels, and of --compress: each is refused, or
// is a value whose own text is that value again.
#include <array>
#include <cstdint>
#include <string>

#include "oracle.h"
#include "plait/compression.h"
#include "plait/extend/pipeline.h"
#include "plait/registry.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

void check_text_of(const LevelPipelines& pipelines) {
  require(LevelPipelines(pipelines.to_text()) == pipelines);
  for (int level = 0; level <= kMaxLevel; ++level) {
    const Pipeline& one = pipelines.of(level);
    require(Pipeline(one.to_text()) == one);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  Pipeline pipeline;
  const bool is_one = accepts({ErrorCode::kInvalidArgument}, [&] { pipeline = text; });
  if (is_one) {
    require(pipeline.to_text() == text);
    require(pipeline.with_recipe("").without_predicted_stage() ==
            pipeline.without_predicted_stage());
    accepts({ErrorCode::kInvalidArgument, ErrorCode::kNotSupported},
            [&] { default_pipelines().open(pipeline, {}); });
  }
  LevelPipelines pipelines;
  if (accepts({ErrorCode::kInvalidArgument}, [&] { pipelines = text; })) {
    check_text_of(pipelines);
    check_text_of(pipeline_of_rounded(pipelines, 0.5));
    require(is_one == (text.find(';') == std::string::npos));
  } else {
    require(!is_one);
  }
  Compression compression;
  if (accepts({ErrorCode::kInvalidArgument}, [&] { compression.add(text); })) {
    constexpr std::array kNames = {"position", "normal", "a"};
    for (const char* const name : kNames)
      check_text_of(compression.pipeline_of({name, ComponentType::kFloat32, 3}));
    const LevelPipelines once = compression.pipeline_of({"a", ComponentType::kUint8, 1});
    compression.add(text);
    require(compression.pipeline_of({"a", ComponentType::kUint8, 1}) == once);
  }
  return 0;
}
