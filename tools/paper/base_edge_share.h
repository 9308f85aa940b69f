// paper/base_edge_share.h: how many vertices of a level lie on base edges (section 2 of the paper).
// These are the vertices that a format with a grid for each patch would store twice.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::paper {

/// The vertices that a level creates.
struct LevelShare {
  int level = 1;
  std::uint64_t born = 0;           ///< all that the level creates
  std::uint64_t on_base_edges = 0;  ///< those of them that lie on base edges
  double share() const { return static_cast<double>(on_base_edges) / static_cast<double>(born); }
  friend bool operator==(const LevelShare&, const LevelShare&) = default;
};

/// Levels 1 to `levels`, from the counts of the mesh alone: with n = 2^(level - 1), an inner edge
/// has n n new vertices and a border edge n (n + 1) / 2, of which n lie on the edge. In a closed
/// mesh the share is 1 / n.
std::vector<LevelShare> base_edge_shares(const BaseMesh& mesh, int levels);

/// The same by counting: every record of every slot is converted to its face index, and lies on a
/// base edge if one of its three weights is zero. O(vertices). Pinned by
/// tests/tools/paper_test.cpp.
std::vector<LevelShare> count_base_edge_shares(const BaseMesh& mesh, int levels);

/// Vertices up to level k, base vertices included, if each patch had a grid of its own:
/// F (2^k + 1)(2^k + 2) / 2.
std::uint64_t replicated_vertices(const BaseMesh& mesh, int level);

}  // namespace plait::paper
