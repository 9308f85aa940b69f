// tools/tune/round_robin.h: tries all pipelines on a sample, in turn, so that the figures are fair
// whenever it ends.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "plait/backends/pipeline.h"
#include "tune/figures.h"
#include "tune/sample.h"
#include "tune/store_bytes.h"

namespace plait::tune {

/// The trials of all attributes with levels, none measured yet: each pipeline of
/// candidate_pipelines() with each grid.
Trials plan_trials(const Store& store, const PipelineRegistry& registry,
                   const std::vector<std::unique_ptr<BlockGrid>>& grids, const Sample& sample);

/// How far the trials are.
struct TrialProgress {
  std::size_t rounds = 0;  ///< complete ones
  std::size_t done = 0;    ///< trials of the round
};

/// In each round, every trial is measured on the next part of its attribute's sample. Ends when
/// `proceed` returns false, or when all parts have been visited `most_visits` times. Pipelines that
/// refuse the store are removed. Returns the number of complete rounds. Errors: those of
/// BlockTrials::measure.
std::size_t measure_in_turn(const Store& store, const PipelineRegistry& registry, StoreBytes& bytes,
                            const std::vector<std::unique_ptr<BlockGrid>>& grids,
                            const Sample& sample, int most_visits, Trials& trials,
                            const std::function<bool(const TrialProgress&)>& proceed);

}  // namespace plait::tune
