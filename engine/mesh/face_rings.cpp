#include "mesh/face_rings.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::vector<std::uint32_t> ascending(std::vector<std::uint32_t> numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

}  // namespace

FaceRings::FaceRings(const Topology& mesh)
    : mesh_(mesh), face_seen_(mesh.faces.size()), vertex_seen_(mesh.vertex_corners.size()) {}

void FaceRings::begin(EdgeId first, EdgeId after) {
  ++turn_;
  faces_.clear();
  for (EdgeId edge = first; edge < after; ++edge)
    for (const FaceSide side : {mesh_.edges[edge].own, mesh_.edges[edge].other})
      if (side.exists()) add(side.face());
  ends_.assign(1, faces_.size());
}

bool FaceRings::grow() {
  const std::size_t end = faces_.size(), begin = ends_.size() > 1 ? ends_[ends_.size() - 2] : 0;
  for (std::size_t at = begin; at < end; ++at)
    for (const VertexId vertex : mesh_.faces[faces_[at]]) {
      if (vertex_seen_[vertex] == turn_) continue;
      vertex_seen_[vertex] = turn_;
      const FaceSide first = mesh_.vertex_corners[vertex];
      FaceSide corner = first;
      do {
        add(corner.face());
        corner = mesh_.next_corner(corner);
      } while (corner.exists() && corner != first);
    }
  ends_.push_back(faces_.size());
  return faces_.size() > end;
}

std::span<const FaceId> FaceRings::faces(std::size_t ring) const {
  return std::span(faces_).first(ends_[std::min(ring, rings())]);
}

std::vector<EdgeId> FaceRings::edges(std::size_t ring) const {
  std::vector<EdgeId> edges;
  for (const FaceId face : faces(ring))
    edges.insert(edges.end(), mesh_.face_edges[face].begin(), mesh_.face_edges[face].end());
  return ascending(std::move(edges));
}

std::vector<VertexId> FaceRings::vertices(std::size_t ring) const {
  std::vector<VertexId> vertices;
  for (const FaceId face : faces(ring))
    vertices.insert(vertices.end(), mesh_.faces[face].begin(), mesh_.faces[face].end());
  return ascending(std::move(vertices));
}

PLAIT_END_NAMESPACE
