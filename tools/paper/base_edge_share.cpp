#include "paper/base_edge_share.h"

#include "plait/edge_index.h"

namespace plait::paper {
namespace {

bool is_on_side(const FaceIndex& point) {
  return point.i == 0 || point.j == 0 || point.i + point.j == std::int64_t{1} << point.level;
}

LevelShare count_level(const BaseMesh& mesh, int level) {
  const Topology topology = mesh.topology();
  const std::int64_t n = slot_side(level);
  LevelShare found{.level = level};
  for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
    const bool border = mesh.edges()[edge].is_border();
    for (std::int64_t row = 0; row < n; ++row)
      for (std::int64_t column = 0; column < (border ? n - row : n); ++column) {
        ++found.born;
        if (is_on_side(face_index(topology, {edge, level, row, column}))) ++found.on_base_edges;
      }
  }
  return found;
}

}  // namespace

std::vector<LevelShare> base_edge_shares(const BaseMesh& mesh, int levels) {
  const std::uint64_t border = mesh.border_edge_count(), inner = mesh.edge_count() - border;
  std::vector<LevelShare> shares;
  for (int level = 1; level <= levels; ++level) {
    const std::uint64_t n = std::uint64_t{1} << (level - 1);
    shares.push_back({level, inner * n * n + border * (n * (n + 1) / 2), mesh.edge_count() * n});
  }
  return shares;
}

std::vector<LevelShare> count_base_edge_shares(const BaseMesh& mesh, int levels) {
  std::vector<LevelShare> shares;
  for (int level = 1; level <= levels; ++level) shares.push_back(count_level(mesh, level));
  return shares;
}

std::uint64_t replicated_vertices(const BaseMesh& mesh, int level) {
  const std::uint64_t side = std::uint64_t{1} << level;
  return mesh.face_count() * ((side + 1) * (side + 2) / 2);
}

}  // namespace plait::paper
