// bench/paper/tables.h: what the paper says of a mesh without running anything on it: counts,
// shares of vertices on base edges (section 2) and spans (section 5.3).
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::paper {

/// The vertices that a level creates, and those of them that lie on base edges (section 2 of the
/// paper): these are the ones that a format with a grid for each patch would store twice.
struct LevelShare {
  int level = 1;
  std::uint64_t born = 0, on_base_edges = 0;
  double share() const { return static_cast<double>(on_base_edges) / static_cast<double>(born); }
  friend bool operator==(const LevelShare&, const LevelShare&) = default;
};

/// Levels 1 to `levels`, from the counts of the mesh alone: with n = 2^(level - 1), an inner edge
/// has n n new vertices and a border edge n (n + 1) / 2, of which n lie on the edge. In a closed
/// mesh the share is 1 / n. Pinned by tests/bench/paper/paper_test.cpp, which counts points.
std::vector<LevelShare> base_edge_shares(const BaseMesh& mesh, int levels);

/// Vertices up to level k, base vertices included, if each patch had a grid of its own:
/// F (2^k + 1)(2^k + 2) / 2.
std::uint64_t replicated_vertices(const BaseMesh& mesh, int level);

/// {"vertices", "edges", "faces", "border_edges", "euler", "counts": [vertices of level k],
/// "shares": [{"level", "born", "on_base_edges"}], "replicated": [vertices of level k if each patch
/// had its own grid], "spans": [{"layout", "face", "loop", "loop_median"}]}. The layouts are given,
/// spatial (the paper's), hilbert and rcm.
nlohmann::json mesh_tables(const BaseMesh& mesh, int levels);

}  // namespace plait::paper
