// tools/subdivide/report.h: the figures of one subdivision, as JSON and for people.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/layout.h"
#include "plait/pager.h"

namespace plait {

struct MeshFigures {
  std::uint64_t vertices = 0, edges = 0, faces = 0, border_edges = 0;
};
MeshFigures figures_of(const BaseMesh& mesh);

struct SubdivideReport {
  std::filesystem::path mesh, store;  ///< store: empty if nothing was kept
  MeshFigures input, base;            ///< as read; as stored (refined base_level times)
  int base_level = 0, levels = 0;
  int resumed_level = 0;                  ///< what was there when the work began
  std::vector<LevelCounts> level_counts;  ///< [level], 0 to levels
  /// All that the user waited: the parts that follow, and what is between them.
  double seconds = 0, import_seconds = 0, layout_seconds = 0, refine_seconds = 0,
         commit_seconds = 0, digest_seconds = 0, cpu_seconds = 0;
  std::uint64_t stored_bytes = 0, peak_rss_bytes = 0, base_mesh_bytes = 0, budget_bytes = 0,
                block_bytes = 0;
  std::string backend, backend_reason, codec, filter, executor, layout, scheme, precision,
      durability, digest;
  bool normals = false, limit = false;
  int threads = 1;
  LayoutSpans spans;
  PagingStatistics paging;  ///< up to the end of the commit

  /// refine_seconds over all vertices made: those of the finest level less those of the input.
  double ns_per_vertex() const;
};

nlohmann::ordered_json to_json(const SubdivideReport& report);
std::string to_text(const SubdivideReport& report);

}  // namespace plait
