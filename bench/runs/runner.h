// bench/runs/runner.h: runs the cells of a plan, round by round, and appends a record for each
// run.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "runs/plan.h"
#include "runs/record.h"

namespace plait::bench {

struct RunnerOptions {
  /// 0: four, and then more of the cells that settled_keys() leaves, until the time is up.
  int rounds = 0;
  double seconds = 600;         ///< no new round begins after this
  bool stops_in_round = false;  ///< the time also ends a round, after its first run
  std::uint64_t seed = 1;
  /// A run beside other programs is done again, and the quieter one stays. With `stops_in_round`
  /// only after the fourth round.
  bool repeat_disturbed = true;
  double least_seconds = 0.3;  ///< a shorter run does its work again, as cold as the first time
  bool fio = true;             ///< also measure floors by fio in the first round
  /// Called before each run with a line; false stops, and what there is stays.
  std::function<bool(const std::string&)> proceed = {};
};

struct RunnerResult {
  int rounds = 0;
  bool finished = false;  ///< false: the time was up, or proceed() said stop
};

/// Rounds that the file has already are not run again. Each disk gets a directory of its own for
/// the time of the call. Errors: kIo for the files of the runner itself; an error inside a run is a
/// record with `failure`. REQUIRES: this process has one thread.
RunnerResult run_cells(const Plan& plan, const RunnerOptions& options,
                       const BackendRegistry& backends, RecordFile& file);

}  // namespace plait::bench
