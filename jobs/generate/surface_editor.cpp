#include "generate/surface_editor.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

/// [side] the other side of the same edge, found among the sides that share their lower vertex.
std::vector<SurfaceEditor::Side> match_sides(const std::vector<std::array<VertexId, 3>>& faces,
                                             std::size_t vertex_count) {
  struct SideFromLower {
    VertexId higher;
    SurfaceEditor::Side side;
  };
  const auto ends = [&faces](std::size_t side) {
    const auto& face = faces[side / 3];
    return std::minmax(face[(side + 1) % 3], face[(side + 2) % 3]);
  };
  std::vector<std::uint32_t> bucket_end(vertex_count + 1, 0);
  for (std::size_t side = 0; side < 3 * faces.size(); ++side) ++bucket_end[ends(side).first + 1];
  for (std::size_t vertex = 0; vertex < vertex_count; ++vertex)
    bucket_end[vertex + 1] += bucket_end[vertex];

  std::vector<SideFromLower> entries(3 * faces.size());
  std::vector<SurfaceEditor::Side> beyond(3 * faces.size(), kNoId);
  std::vector<std::uint32_t> filled(bucket_end.begin(), bucket_end.end() - 1);
  for (std::size_t side = 0; side < 3 * faces.size(); ++side) {
    const auto [lower, higher] = ends(side);
    const auto mine = static_cast<SurfaceEditor::Side>(side);
    std::uint32_t at = bucket_end[lower];
    while (at < filled[lower] && entries[at].higher != higher) ++at;
    if (at < filled[lower]) {
      beyond[side] = entries[at].side;
      beyond[entries[at].side] = mine;
    } else {
      entries[filled[lower]++] = {higher, mine};
    }
  }
  return beyond;
}

}  // namespace

SurfaceEditor::SurfaceEditor(IndexedMesh mesh)
    : positions_(std::move(mesh.positions)),
      faces_(std::move(mesh.faces)),
      beyond_(match_sides(faces_, positions_.size())),
      corner_of_vertex_(positions_.size(), kNoId),
      live_vertex_count_(positions_.size()),
      mark_of_vertex_(positions_.size(), 0) {
  for (Side side = 0; side < side_limit(); ++side) corner_of_vertex_[apex(side)] = side;
}

bool SurfaceEditor::is_on_border(VertexId vertex) const {
  bool border = false;
  for_each_link_side(vertex, [&](Side side) {
    border = border || is_border(next(side)) || is_border(previous(side));
  });
  return border;
}

int SurfaceEditor::valence(VertexId vertex) const {
  int edges = 0;
  for_each_link_side(vertex, [&](Side side) { edges += is_border(next(side)) ? 2 : 1; });
  return edges;
}

int SurfaceEditor::count_common_neighbours(VertexId a, VertexId b) const {
  mark_ += 2;
  for_each_link_side(
      a, [&](Side side) { mark_of_vertex_[start(side)] = mark_of_vertex_[end(side)] = mark_; });
  int common = 0;
  for_each_link_side(b, [&](Side side) {
    for (const VertexId neighbour : {start(side), end(side)}) {
      if (mark_of_vertex_[neighbour] != mark_) continue;
      mark_of_vertex_[neighbour] = mark_ + 1;
      ++common;
    }
  });
  return common;
}

bool SurfaceEditor::can_collapse(Side side) const {
  const VertexId a = start(side), b = end(side), c = apex(side);
  if (is_border(side)) {
    // The last triangle of a component has no neighbour to join.
    if (is_border(next(side)) && is_border(previous(side))) return false;
    return count_common_neighbours(a, b) == 1;
  }
  if (is_on_border(a) && is_on_border(b)) return false;
  if (count_common_neighbours(a, b) != 2) return false;
  // With two common neighbours, an inner apex of valence 3 means that the surface is a tetrahedron.
  return valence(c) != 3 || is_on_border(c);
}

void SurfaceEditor::join(Side first, Side second) {
  if (first != kNoId) beyond_[first] = second;
  if (second != kNoId) beyond_[second] = first;
}

void SurfaceEditor::collapse(Side side, Vector3<double> position) {
  const VertexId kept = start(side), removed = end(side);
  for_each_link_side(removed, [&](Side corner) { faces_[corner / 3][corner % 3] = kept; });
  for (const Side dying : {side, beyond_[side]}) {
    if (dying == kNoId) continue;
    const Side first = beyond_[next(dying)], second = beyond_[previous(dying)];
    join(first, second);
    const VertexId opposite = apex(dying);
    // At least one of the two sides exists, because can_collapse() was true. Both now run between
    // the apex and the vertex that is kept.
    const Side survivor = first != kNoId ? first : second;
    const bool starts_at_apex = start(survivor) == opposite;
    corner_of_vertex_[opposite] = starts_at_apex ? next(survivor) : previous(survivor);
    corner_of_vertex_[kept] = starts_at_apex ? previous(survivor) : next(survivor);
    faces_[dying / 3][0] = kNoId;
  }
  corner_of_vertex_[removed] = kNoId;
  positions_[kept] = position;
  --live_vertex_count_;
}

IndexedMesh SurfaceEditor::take() && {
  std::vector<VertexId> new_id(positions_.size(), kNoId);
  VertexId next_id = 0;
  for (std::size_t vertex = 0; vertex < positions_.size(); ++vertex) {
    if (corner_of_vertex_[vertex] == kNoId) continue;
    positions_[next_id] = positions_[vertex];
    new_id[vertex] = next_id++;
  }
  positions_.resize(next_id);
  std::erase_if(faces_, [](const auto& face) { return face[0] == kNoId; });
  for (auto& face : faces_)
    for (VertexId& vertex : face) vertex = new_id[vertex];
  return {std::move(positions_), std::move(faces_)};
}

}  // namespace generation
PLAIT_END_NAMESPACE
