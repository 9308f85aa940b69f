// bench/micro/support.h: functions that several measurements use.
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "plait/subdivide.h"

namespace plait::bench {

template <class Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The processor time of this thread. For work of one thread on a machine that other programs use.
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

/// REQUIRES: `values` is not empty; the same for spread().
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

/// A closed mesh of 8 * 4^refinements faces.
inline BaseMesh octahedron(int refinements) {
  IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  return rebase(BaseMesh::build(mesh), refinements, Scheme::kLoop);
}

}  // namespace plait::bench
