// tools/measure.h: measures time and memory of a run.
#pragma once

#include <chrono>
#include <cstdint>

namespace plait {

class Stopwatch {
 public:
  /// Seconds since construction or the last lap().
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  double lap() {
    const double elapsed = seconds();
    start_ = std::chrono::steady_clock::now();
    return elapsed;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Seconds since the process started: the time that the user has waited so far.
double seconds_since_start();

/// User and system time of all threads so far (getrusage).
double cpu_seconds();

/// The largest resident set so far: VmHWM of /proc/self/status. (A process inherits ru_maxrss from
/// its parent, so ru_maxrss can be too large.) 0 if the figure is not available.
std::uint64_t peak_rss_bytes();

}  // namespace plait
