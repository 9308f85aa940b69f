// tools/measure.h: what a run took of the machine.
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

/// Seconds since the process began to run: what the user has waited so far.
double seconds_since_start();

/// User and system time of all threads so far (getrusage).
double cpu_seconds();

/// The largest resident set so far: VmHWM of /proc/self/status, and not ru_maxrss, which a process
/// inherits from the one that started it. 0 where it cannot be had.
std::uint64_t peak_rss_bytes();

}  // namespace plait
