#include "tune/round_robin.h"

#include <algorithm>
#include <map>
#include <optional>

#include "plait/block_maker.h"
#include "plait/error.h"
#include "tune/block_trial.h"
#include "tune/candidates.h"
#include "tune/store_copies.h"

namespace plait::tune {
namespace {

const BlockGrid& grid_of(const Trial& trial, const std::vector<std::unique_ptr<BlockGrid>>& grids) {
  return **std::ranges::find(grids, trial.block_bytes,
                             [](const auto& each) { return each->block_bytes(); });
}

/// Removes the pipelines with the stage `predicted` of the attributes of which a scheme makes no
/// block of the sample: what was displaced or smoothed is stored as without the stage.
void remove_idle_stages(const std::vector<std::unique_ptr<BlockGrid>>& grids, const Sample& sample,
                        const std::vector<AttributeId>& ids, BlockTrials& blocks, Trials& trials) {
  std::map<std::size_t, bool> is_made;  // [attribute]
  std::erase_if(trials.trials, [&](const Trial& trial) {
    if (!trial.is_predicted) return false;
    const auto [found, is_new] = is_made.try_emplace(trial.attribute, false);
    if (is_new)
      found->second =
          std::ranges::any_of(sample.parts[ids[trial.attribute]], [&](const SamplePart& part) {
            return blocks.is_made(grid_of(trial, grids), part, trial.pipeline);
          });
    return !found->second;
  });
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
    const BlockMakers* const makers = registry.block_makers();
    const bool is_made =
        makers != nullptr && !makers->recipe(store.provenance(), schema, finest).empty();
    const auto& rounding = store.rounding(id);
    const std::optional<double> step =
        rounding && rounding->step > 0 ? std::optional(rounding->step) : std::nullopt;
    for (const std::string& pipeline : candidate_pipelines(registry, schema, is_made, step))
      for (const auto& grid : grids)
        trials.trials.push_back({number, grid->block_bytes(), pipeline,
                                 static_cast<double>(grid->geometry(id, finest).max_block_bytes()),
                                 false, std::vector<Outcome>(attribute.parts),
                                 has_predicted_stage(pipeline)});
  }
  return trials;
}

std::size_t measure_in_turn(const Store& store, const PipelineRegistry& registry, StoreBytes& bytes,
                            const std::vector<std::unique_ptr<BlockGrid>>& grids,
                            const Sample& sample, int most_visits, Trials& trials,
                            const std::function<bool(const TrialProgress&)>& proceed) {
  const std::vector<AttributeId> ids = refined_attributes(store);
  BlockTrials blocks(registry, bytes);
  remove_idle_stages(grids, sample, ids, blocks, trials);
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
      const BlockGrid& grid = grid_of(trial, grids);
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
