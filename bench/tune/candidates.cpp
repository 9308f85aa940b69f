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

/// The filters before a codec.
using Chain = std::vector<PipelineStage>;

std::vector<Chain> chains(const PipelineRegistry& registry) {
  const std::vector<std::string> filters = registry.filter_names();
  const bool has_shuffle = contains(filters, "shuffle");
  std::vector<Chain> chains = {{}};
  if (has_shuffle) chains.push_back({{"shuffle"}});
  for (const std::string& filter : filters) {
    if (filter == "shuffle") continue;
    if (has_shuffle) chains.push_back({{filter}, {"shuffle"}});
    // The filters that come with plait leave numbers, whose bytes are always grouped afterwards.
    if (!contains(default_pipelines().filter_names(), filter)) chains.push_back({{filter}});
  }
  return chains;
}

/// Filters before `bitpack`, which wants the numbers that a filter leaves, and no bytes.
std::vector<Chain> predictions(const PipelineRegistry& registry) {
  std::vector<Chain> chains;
  for (const std::string& filter : registry.filter_names())
    if (filter != "shuffle") chains.push_back({{filter}});
  return chains;
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
  std::vector<Pipeline> tried = {"none"};
  std::vector<Pipeline> all;
  for (const PipelineStage& codec : codecs(registry))
    for (const Chain& chain : codec.name == "bitpack" ? predictions(registry) : chains(registry)) {
      Pipeline& pipeline = all.emplace_back();
      pipeline.filters = chain;
      pipeline.codec = codec;
      if (filters_of(registry, schema, pipeline) != chain.size()) all.pop_back();
    }
  for (const CompressionPreset& preset : compression_presets()) {
    const Pipeline pipeline = preset_pipeline(preset.name, schema).without_predicted_stage();
    if (filters_of(registry, schema, pipeline) == pipeline.filters.size() &&
        !contains(tried, pipeline))
      tried.push_back(pipeline);
  }
  for (const Pipeline& pipeline : all)
    if (!contains(tried, pipeline)) tried.push_back(pipeline);
  if (step)
    for (const Pipeline& pipeline : std::vector(tried)) {
      const Pipeline rounded = pipeline_of_rounded(pipeline, *step).of(0);
      if (!contains(tried, rounded) && filters_of(registry, schema, rounded))
        tried.push_back(rounded);
    }
  return tried;
}

}  // namespace plait::tune
