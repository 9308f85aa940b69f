// process_figures.h: what this process has used so far.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// User and system time of all threads so far (getrusage).
double cpu_seconds();

/// The largest resident set so far: VmHWM of /proc/self/status. (A process inherits ru_maxrss from
/// its parent, so ru_maxrss can be too large.) 0 if the figure is not available.
std::uint64_t peak_rss_bytes();

PLAIT_END_NAMESPACE
