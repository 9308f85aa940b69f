// tools/measure.h: measures time and memory of a run.
#pragma once

#include "base/stopwatch.h"
#include "process_figures.h"

namespace plait {

/// Seconds since the process started: the time that the user has waited so far.
double seconds_since_start();

}  // namespace plait
