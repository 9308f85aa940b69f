// plait/visit_options.h: how far visit_vertices() goes, and the memory that it needs.
#pragma once

#include <cstdint>
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
  int threads = 1;  ///< 1 to 1024; 0: all processors
  /// Counts vertices; called between blocks. Levels that a cancelled visit writes stay unfinished.
  /// The last call has done == total, and its result does not matter.
  ProgressCallback progress = {};
};

/// The memory that a visit needs.
struct VisitNeeds {
  std::uint64_t frame_bytes = 0;  ///< of the pager's budget: the smallest budget for the visit
  /// In addition to the budget: for each attribute whose rings it reads, the grid of an edge for
  /// each thread, and two records for each base edge.
  std::uint64_t ring_bytes = 0;
};

PLAIT_END_NAMESPACE
