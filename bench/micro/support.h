// bench/micro/support.h: functions that several measurements use.
#pragma once

#include <time.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "instrument/page.h"
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

/// "1.23".
instrument::TableCell number(double value, int digits = 2);
/// "1.23", the median of `values` times `scale`. REQUIRES: there is a value; also for spread().
instrument::TableCell middle(std::span<const double> values, double scale = 1, int digits = 2);
/// "1.23 (1.20 to 1.31)": with the smallest and the largest.
instrument::TableCell spread(std::span<const double> values, double scale = 1, int digits = 2);

/// Prints a line and the table as Markdown.
void print_table(const std::string& about, const instrument::Table& table);

/// Prints a line to standard error if it is a terminal.
void say_progress(const std::string& text);

/// A closed mesh of 8 * 4^refinements faces.
inline BaseMesh octahedron(int refinements) {
  IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  return rebase(BaseMesh::build(mesh), refinements, Scheme::kLoop);
}

}  // namespace plait::bench
