// tests/engine/execution/naive_reach.h: which edges a kernel may touch at an edge, as sets found
// from the faces' corners alone.
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/sweep.h"

namespace plait::test {

/// [edge] the edges in reach.
inline std::vector<std::set<EdgeId>> naive_reach(const BaseMesh& mesh, Reach reach) {
  std::map<std::pair<VertexId, VertexId>, EdgeId> edge_of;
  for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge)
    edge_of[std::minmax(mesh.edges()[edge].start, mesh.edges()[edge].end)] = edge;
  std::vector<std::vector<std::set<EdgeId>>> faces_of(mesh.edge_count());  // as their edges
  for (const auto& [a, b, c] : mesh.faces()) {
    const std::set<EdgeId> face = {edge_of.at(std::minmax(a, b)), edge_of.at(std::minmax(b, c)),
                                   edge_of.at(std::minmax(c, a))};
    for (const EdgeId edge : face) faces_of[edge].push_back(face);
  }
  const auto grown = [&](const std::set<EdgeId>& edges) {
    std::set<EdgeId> result = edges;
    for (const EdgeId edge : edges)
      for (const std::set<EdgeId>& face : faces_of[edge]) result.insert(face.begin(), face.end());
    return result;
  };
  std::vector<std::set<EdgeId>> result;
  for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
    std::set<EdgeId> edges = {edge};
    if (reach != Reach::kOwn) edges = grown(edges);
    if (reach == Reach::kRing) edges = grown(edges);
    result.push_back(std::move(edges));
  }
  return result;
}

}  // namespace plait::test
