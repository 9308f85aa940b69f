#include "tune/round_robin.h"

#include <algorithm>

#include "plait/error.h"
#include "tune/block_trial.h"
#include "tune/candidates.h"

namespace plait::tune {
namespace {

/// The attributes that have levels, in the order of Trials::attributes.
std::vector<AttributeId> refined_attributes(const Store& store) {
  std::vector<AttributeId> ids;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level > store.base_level()) ids.push_back(id);
  return ids;
}

}  // namespace

Trials plan_trials(const Store& store, const PipelineRegistry& registry,
                   const std::vector<std::unique_ptr<BlockGrid>>& grids, const Sample& sample) {
  Trials trials;
  for (const AttributeId id : refined_attributes(store)) {
    const auto& [schema, finest] = store.attributes()[id];
    SampledAttribute attribute{schema, 0, sample.parts[id].size(), sample.is_whole[id]};
    for (int level = store.base_level() + 1; level <= finest; ++level)
      attribute.raw_bytes += static_cast<double>(grids[0]->geometry(id, level).total_bytes());
    const std::size_t number = trials.attributes.size();
    trials.attributes.push_back(attribute);
    for (const std::string& pipeline : candidate_pipelines(registry, schema))
      for (const auto& grid : grids)
        trials.trials.push_back({number, grid->block_bytes(), pipeline,
                                 static_cast<double>(grid->geometry(id, finest).max_block_bytes()),
                                 false, std::vector<Outcome>(attribute.parts)});
  }
  return trials;
}

std::size_t measure_in_turn(const Store& store, const PipelineRegistry& registry, StoreBytes& bytes,
                            const std::vector<std::unique_ptr<BlockGrid>>& grids,
                            const Sample& sample, int most_visits, Trials& trials,
                            const std::function<bool(const TrialProgress&)>& proceed) {
  const std::vector<AttributeId> ids = refined_attributes(store);
  BlockTrials blocks(registry, bytes);
  std::size_t most_parts = 0;
  for (const SampledAttribute& attribute : trials.attributes)
    most_parts = std::max(most_parts, attribute.parts);
  const std::size_t most_rounds = most_parts * static_cast<std::size_t>(most_visits);
  for (std::size_t round = 0; round < most_rounds; ++round)
    for (std::size_t at = 0; at < trials.trials.size();) {
      if (!proceed({round, at})) return round;
      Trial& trial = trials.trials[at];
      if (trial.outcomes.empty()) {
        ++at;
        continue;
      }
      const std::size_t number = round % trial.outcomes.size();
      const SamplePart& part = sample.parts[ids[trial.attribute]][number];
      const BlockGrid& grid = **std::ranges::find(
          grids, trial.block_bytes, [](const auto& each) { return each->block_bytes(); });
      try {
        if (blocks.needs_other_blocks(grid, part, trial.pipeline)) trial.needs_other_blocks = true;
        blocks.measure(grid, part, trial.pipeline, trial.outcomes[number]);
        ++at;
      } catch (const Error& error) {
        // For example normals in a store that has no positions.
        if (error.code() != ErrorCode::kNotSupported && error.code() != ErrorCode::kInvalidArgument)
          throw;
        trials.trials.erase(trials.trials.begin() + static_cast<std::ptrdiff_t>(at));
      }
    }
  return most_rounds;
}

}  // namespace plait::tune
