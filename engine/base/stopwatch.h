// base/stopwatch.h: measures elapsed time.
#pragma once

#include <chrono>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Measures time that passes, not processor time.
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

PLAIT_END_NAMESPACE
