// What every measurement needs.
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace plait::bench {

template <class Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Processor time of this thread alone: for work of one thread, on a machine that others use.
template <class Work>
double thread_seconds(Work work) {
  const auto now = [] {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

/// REQUIRES: not empty, as for spread().
inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

struct Spread {
  double smallest, largest;
};
inline Spread spread(const std::vector<double>& values) {
  return {*std::ranges::min_element(values), *std::ranges::max_element(values)};
}

}  // namespace plait::bench
