// tools/measure.h: what a run took of the machine.
#pragma once

#include <cstdint>

#include "plait/stopwatch.h"

namespace plait {

/// Seconds since the process began to run: what the user has waited so far.
double seconds_since_start();

/// User and system time of all threads so far (getrusage).
double cpu_seconds();

/// The largest resident set so far: VmHWM of /proc/self/status, and not ru_maxrss, which a process
/// inherits from the one that started it. 0 where it cannot be had.
std::uint64_t peak_rss_bytes();

}  // namespace plait
