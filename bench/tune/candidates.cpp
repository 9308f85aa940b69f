#include <algorithm>
#include <cstdint>

#include "plait/compression.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "tune/sample.h"

namespace plait::tune {
namespace {

bool contains(const auto& values, const auto& value) {
  return std::ranges::find(values, value) != values.end();
}

std::vector<PipelineStage> codecs(const PipelineRegistry& registry) {
  std::vector<PipelineStage> codecs;
  for (const std::string& codec : registry.codec_names()) {
    if (codec == "none") continue;
    if (codec == "zstd")
      codecs.insert(codecs.end(), {{"zstd", "1"}, {"zstd", "3"}, {"zstd", "9"}});
    else
      codecs.push_back({codec});
  }
  return codecs;
}

/// The filters that are tried before a codec.
std::vector<std::vector<PipelineStage>> chains_before(const PipelineStage& codec,
                                                      const PipelineRegistry& registry) {
  // `bitpack` wants the numbers that a filter leaves, and no bytes.
  const bool wants_numbers = codec.name == "bitpack";
  std::vector<std::vector<PipelineStage>> chains;
  if (!wants_numbers) {
    chains.emplace_back();
    chains.push_back({{"shuffle"}});
  }
  for (const std::string& filter : registry.filter_names()) {
    if (filter == "shuffle") continue;
    if (!wants_numbers) chains.push_back({{filter}, {"shuffle"}});
    // The filters that come with plait leave numbers, whose bytes are always grouped afterwards.
    if (wants_numbers || !contains(default_pipelines().filter_names(), filter))
      chains.push_back({{filter}});
  }
  return chains;
}

/// The number of filters that change records of this type; nothing if one of them refuses them.
std::optional<std::size_t> filters_of(const PipelineRegistry& registry,
                                      const AttributeSchema& schema, const Pipeline& pipeline) {
  try {
    FilterLevel level;
    level.schema = schema;
    return registry.open(pipeline, level).filters.size();
  } catch (const Error& error) {
    if (!is_refusal(error)) throw;
    return std::nullopt;
  }
}

}  // namespace

std::vector<Pipeline> candidate_pipelines(const PipelineRegistry& registry,
                                          const AttributeSchema& schema,
                                          std::optional<double> step) {
  std::vector<Pipeline> candidates = {"none"};
  const auto add = [&](const Pipeline& pipeline) {
    if (!contains(candidates, pipeline)) candidates.push_back(pipeline);
  };
  const auto add_if_all_filters_work = [&](const Pipeline& pipeline) {
    if (filters_of(registry, schema, pipeline) == pipeline.filters.size()) add(pipeline);
  };
  for (const CompressionPreset& preset : compression_presets())
    add_if_all_filters_work(preset_pipeline(preset.name, schema).without_predicted_stage());
  for (const PipelineStage& codec : codecs(registry))
    for (const std::vector<PipelineStage>& filters : chains_before(codec, registry)) {
      Pipeline pipeline;
      pipeline.filters = filters;
      pipeline.codec = codec;
      add_if_all_filters_work(pipeline);
    }
  if (step)
    for (const Pipeline& pipeline : std::vector(candidates)) {
      const Pipeline rounded = pipeline_of_rounded(pipeline, *step).of(0);
      if (filters_of(registry, schema, rounded)) add(rounded);
    }
  return candidates;
}

}  // namespace plait::tune
