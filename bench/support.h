// What every measurement needs.
#pragma once

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
