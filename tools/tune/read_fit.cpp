#include "tune/read_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plait::tune {

ReadFit fit_reads(const std::vector<ReadProbe>& probes, Machine machine) {
  ReadFit best;
  double least = std::numeric_limits<double>::infinity();
  constexpr int kSteps = 40;
  for (int step = 0; step <= kSteps; ++step) {
    machine.reading = {static_cast<double>(step) / kSteps, 1};
    double sum = 0, squares = 0, weights = 0;
    for (const ReadProbe& probe : probes) {
      double all = 0;
      for (const double seconds : probe.seconds) all += seconds;
      const std::vector<double> reads = modelled_reads(probe.works, machine);
      for (std::size_t id = 0; id < probe.works.size(); ++id) {
        const double modelled = reads[id];
        if (!(modelled > 0) || !(probe.seconds[id] > 0)) continue;
        // Each probe counts the same, and its attributes by their time.
        const double weight = probe.seconds[id] / all;
        const double error = std::log(probe.seconds[id] / modelled);
        sum += weight * error;
        squares += weight * error * error;
        weights += weight;
      }
    }
    if (!(weights > 0)) break;
    const double mean = sum / weights, variance = squares / weights - mean * mean;
    // Of equal fits the first one stays.
    if (variance + 1e-12 < least) {
      least = variance;
      best = {machine.reading.added, std::exp(mean)};
    }
  }
  return best;
}

std::vector<ReadCorrection> corrections_of(const Trials& trials,
                                           const std::vector<ReadProbe>& probes,
                                           const Machine& machine) {
  std::vector<ReadCorrection> corrections;
  for (const ReadProbe& probe : probes) {
    ReadCorrection correction{
        probe.choice.block_bytes, probe.choice.trials, stores_raw(trials, probe.choice), {}};
    const std::vector<double> reads = modelled_reads(probe.works, machine);
    for (std::size_t id = 0; id < probe.works.size(); ++id) {
      const double modelled = reads[id];
      correction.factors.push_back(
          modelled > 0 ? std::clamp(probe.seconds[id] / modelled, 0.1, 10.0) : 1.0);
    }
    corrections.push_back(std::move(correction));
  }
  return corrections;
}

}  // namespace plait::tune
