#include "tune/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "plait/backends/compression.h"
#include "plait/block_maker.h"
#include "plait/error.h"

namespace plait::tune {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// Filters before the codec; an empty text for none.
std::vector<std::string> chains(const PipelineRegistry& registry) {
  const std::vector<std::string> filters = registry.filter_names();
  const bool has_shuffle = contains(filters, "shuffle");
  std::vector<std::string> chains = {""};
  if (has_shuffle) chains.emplace_back("shuffle");
  for (const std::string& filter : filters) {
    if (filter == "shuffle") continue;
    if (filter == "bytedelta") {  // works on the bytes that shuffle has grouped
      if (has_shuffle) chains.emplace_back("shuffle+bytedelta");
      continue;
    }
    if (has_shuffle) chains.push_back(filter + "+shuffle");
    // The filters that come with plait leave numbers, whose bytes are always grouped afterwards.
    if (!contains(default_pipelines().filter_names(), filter)) chains.push_back(filter);
  }
  return chains;
}

/// Filters before `bitpack`, which wants the numbers that a filter leaves, and no bytes.
std::vector<std::string> predictions(const PipelineRegistry& registry) {
  std::vector<std::string> filters = registry.filter_names();
  std::erase_if(filters,
                [](const std::string& name) { return name == "shuffle" || name == "bytedelta"; });
  return filters;
}

std::vector<std::string> codecs(const PipelineRegistry& registry) {
  std::vector<std::string> codecs;
  for (const std::string& codec : registry.codec_names()) {
    if (codec == "none") continue;
    if (codec == "zstd")
      codecs.insert(codecs.end(), {"zstd:1", "zstd:3", "zstd:9"});
    else
      codecs.push_back(codec);
  }
  return codecs;
}

/// Behind the stage `predicted`: one pipeline for each speed of the codec. What they do matters for
/// the blocks that the scheme does not make.
std::vector<std::string> predicted_pipelines(const AttributeSchema& schema) {
  std::vector<std::string> pipelines;
  for (const CompressionPreset& preset : compression_presets()) {
    if (preset.name == "none") continue;
    const std::string pipeline = without_predicted_stage(preset_pipeline(preset.name, schema));
    pipelines.push_back(fmt::format("{}+{}", kPredictedStage, pipeline));
  }
  pipelines.push_back(fmt::format("{}+shuffle,lz4", kPredictedStage));
  return pipelines;
}

/// The number of filters that change records of this type; nothing if one of them refuses them.
std::optional<std::size_t> filters_of(const PipelineRegistry& registry,
                                      const AttributeSchema& schema, const std::string& pipeline) {
  try {
    FilterLevel level;
    level.schema = schema;
    return registry.make(pipeline, level).filters.size();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotSupported || error.code() == ErrorCode::kInvalidArgument)
      return std::nullopt;
    throw;
  }
}

/// Whether the filters of the chain change records of this type, all of them.
bool suits(const PipelineRegistry& registry, const AttributeSchema& schema,
           const std::string& chain, const std::string& pipeline) {
  const std::size_t filters =
      chain.empty() ? 0 : 1 + static_cast<std::size_t>(std::ranges::count(chain, '+'));
  return filters_of(registry, schema, pipeline) == filters;
}

bool can_be_made(const PipelineRegistry& registry, const AttributeSchema& schema,
                 const std::string& pipeline) {
  return filters_of(registry, schema, pipeline).has_value();
}

}  // namespace

std::vector<std::string> candidate_pipelines(const PipelineRegistry& registry,
                                             const AttributeSchema& schema, bool is_made,
                                             std::optional<double> step) {
  std::vector<std::string> tried = {"none"};
  std::vector<std::string> all;
  for (const std::string& codec : codecs(registry))
    for (const std::string& chain : codec == "bitpack" ? predictions(registry) : chains(registry)) {
      std::string pipeline = chain.empty() ? codec : fmt::format("{},{}", chain, codec);
      if (suits(registry, schema, chain, pipeline)) all.push_back(std::move(pipeline));
    }
  for (const CompressionPreset& preset : compression_presets()) {
    const std::string pipeline = without_predicted_stage(preset_pipeline(preset.name, schema));
    if (contains(all, pipeline) && !contains(tried, pipeline)) tried.push_back(pipeline);
  }
  for (const std::string& pipeline : all)
    if (!contains(tried, pipeline)) tried.push_back(pipeline);
  if (step)
    for (const std::string& pipeline : std::vector(tried)) {
      const std::string rounded = pipeline_of_rounded(pipeline, *step);
      if (!contains(tried, rounded) && can_be_made(registry, schema, rounded))
        tried.push_back(rounded);
    }
  if (is_made)
    for (const std::string& pipeline : predicted_pipelines(schema))
      if (can_be_made(registry, schema, pipeline)) tried.push_back(pipeline);
  return tried;
}

std::vector<std::uint64_t> candidate_block_sizes(std::uint64_t own_block_bytes) {
  std::vector<std::uint64_t> sizes = {64u << 10, 256u << 10, 1u << 20, own_block_bytes};
  std::ranges::sort(sizes);
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

}  // namespace plait::tune
