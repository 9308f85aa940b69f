// tools/tune/read_fit.h: how well reads overlap the disk and the processors, from choices that were
// stored on the measured disk and read. Pinned by tests/tools/tune/read_fit_test.cpp.
#pragma once

#include <vector>

#include "tune/choices.h"
#include "tune/disk_model.h"

namespace plait::tune {

/// A choice that was stored on the measured disk, and read from there, cold. All figures are of the
/// levels that were stored.
struct ReadProbe {
  Choice choice;
  int finest_level = 0;
  std::vector<Work> works;  ///< [attribute] stored bytes are measured, times are from the trials
  std::vector<double> seconds;  ///< [attribute] measured, the median
  bool is_cold = true;
};

/// The fit with the least squares of the logarithm of measured / modelled, over all attributes of
/// all probes. `machine` without a fit. Perfect overlap if there are no probes.
ReadFit fit_reads(const std::vector<ReadProbe>& probes, Machine machine);

/// What remains between the model with its fit and each probe. Factors are within 1/10 and 10: a
/// read of next to nothing says nothing of longer ones.
std::vector<ReadCorrection> corrections_of(const Trials& trials,
                                           const std::vector<ReadProbe>& probes,
                                           const Machine& machine);

}  // namespace plait::tune
