// tools/measure.h: measures time and memory of a run.
#pragma once

#include <cstdint>

#include "base/stopwatch.h"

namespace plait {

/// Seconds since the process started: the time that the user has waited so far.
double seconds_since_start();

/// User and system time of all threads so far (getrusage).
double cpu_seconds();

/// The largest resident set so far: VmHWM of /proc/self/status. (A process inherits ru_maxrss from
/// its parent, so ru_maxrss can be too large.) 0 if the figure is not available.
std::uint64_t peak_rss_bytes();

}  // namespace plait
