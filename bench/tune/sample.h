// bench/tune/sample.h: tries every pipeline on the coarser levels of a surface, drops what is
// dominated, and proposes what deserves to be stored in full beside the presets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tune/rounds.h"

namespace plait::tune {

/// Pipelines for records of this type, from the codecs and filters of `registry`, those of plug-ins
/// too. "none" and the presets come first. Then each codec alone and after each chain of filters:
/// `shuffle`, each other filter alone and with `shuffle` behind it. Pipelines that refuse the type,
/// or that do the same as an earlier one, are left out.
///
/// `step`: the records were rounded to its multiples, so each pipeline comes with filters that
/// count in steps too. No candidate rounds anything by itself, and none has the stage `predicted`.
std::vector<Pipeline> candidate_pipelines(const PipelineRegistry& registry,
                                          const AttributeSchema& schema,
                                          std::optional<double> step = {});

/// What one attribute takes, or would take, with one pipeline.
struct SampledPipeline {
  Pipeline pipeline;
  CopyFigures part;
  bool can_change = true;
};

struct Sample {
  std::uint64_t bytes = 0;
  std::vector<AttributeSchema> attributes;                  ///< those with levels
  std::vector<std::vector<SampledPipeline>> pipelines;      ///< [attribute]
  std::map<std::string, std::vector<std::string>> refused;  ///< [why] "normal=lz4"
  bool is_complete = true;  ///< false if the time was up before the end
};

/// Stores and reads the levels that coarse_levels_in_memory() takes, with each pipeline of
/// candidate_pipelines(), under `directory`. Ends early if `proceed` returns false. Errors: those
/// of coding, reading and writing, unless a pipeline refuses the records.
Sample take_sample(const Store& source, std::uint64_t most_bytes,
                   const std::filesystem::path& directory, Reads reads,
                   const PipelineRegistry& registry, const Proceed& proceed);

/// Up to `most` choices that are likely to be the best for the goal, and that are not in
/// `measured`, each of which has a run. What an attribute takes with a pipeline is scaled from the
/// sample to the whole, as the measured choices with the same pipelines say; the disk's speed is
/// that of `none`, which is the first of `measured`. The estimates only propose: what is advised
/// was measured.
std::vector<Choice> propose(const Sample& sample, const std::vector<Measured>& measured, Goal goal,
                            std::size_t most);

/// The places of those that no other one beats in bytes, writing and reading.
std::vector<std::size_t> not_dominated(const std::vector<SampledPipeline>& pipelines);

}  // namespace plait::tune
