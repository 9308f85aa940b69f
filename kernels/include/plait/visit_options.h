// plait/visit_options.h: how far visit_vertices() goes.
#pragma once

#include <functional>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

/// How far a visit goes, by how many threads, and who watches it.
struct VisitOptions {
  std::string name = "visit";  ///< for errors
  /// Visits the vertices of levels 0 to `level`. -1: the finest level of the attributes, which must
  /// then have equally many levels.
  int level = -1;
  /// 1 to 1024; 0: all processors. The budget of the store lends a visit that reads rings the grids
  /// of all threads but the first one. The visit takes fewer threads if the budget does not hold
  /// these grids and the blocks.
  int threads = 1;
  /// Called once, by the thread that calls visit_vertices(), before the visit changes anything,
  /// with the number of threads that the visit takes.
  std::function<void(int threads)> begins = {};
  /// Counts vertices; called between blocks. Levels that a cancelled visit writes stay unfinished.
  /// The last call has done == total, and its result does not matter.
  ProgressCallback progress = {};
};

PLAIT_END_NAMESPACE
