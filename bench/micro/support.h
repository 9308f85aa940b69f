// bench/micro/support.h: functions that several measurements use.
#pragma once

#include <time.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/store.h"
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

/// A column of a table of measurements.
struct Figure {
  std::string name;
  int digits = 2;
  bool spread = false;  ///< with the smallest and the largest value
};

/// A table of what runs measured: each figure is the median of the runs of its row.
class Measurements {
 public:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  /// `labels`: the columns before the figures, with '|' between them, and '#' before numbers.
  Measurements(std::string labels, std::vector<Figure> figures);
  /// A run of the row with these labels: a value for each figure, or kNone. Rows stand in the order
  /// in which they were first added to.
  void add(const std::vector<std::string>& labels, std::initializer_list<double> values);
  /// Prints a line, and the table as Markdown.
  void print(const std::string& about) const;

 private:
  struct Row {
    std::vector<std::string> labels;
    std::vector<std::vector<double>> values;  ///< [figure]
  };
  std::string labels_;
  std::vector<Figure> figures_;
  std::vector<Row> rows_ = {};
};

/// A closed mesh of 8 * 4^refinements faces.
inline BaseMesh octahedron(int refinements) {
  IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  return rebase(BaseMesh::build(mesh), refinements, Scheme::kLoop);
}

/// The mesh of a file; without a name, an octahedron.
inline LaidOutMesh mesh_or_octahedron(const std::string& file, int refinements, LayoutKind layout) {
  return lay_out(file.empty() ? octahedron(refinements) : read_base_mesh(file), layout);
}

/// A store of positions, refined to `level`, committed and open for reading. What was at `path` is
/// removed.
inline Store refined_store(const std::filesystem::path& path, const LaidOutMesh& base, int level,
                           const StoreOptions& options) {
  std::filesystem::remove_all(path);
  {
    Store store = Store::create(path, base, options, default_backends());
    add_base_positions(store);
    subdivide(store, {.levels = level});
    store.commit();
  }
  return Store::open(path, {.budget_bytes = options.budget_bytes}, default_backends());
}

}  // namespace plait::bench
