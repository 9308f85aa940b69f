#include "plait/base_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/connectivity.h"
#include "mesh/parallel_parts.h"
#include "plait/error.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

[[noreturn]] void refuse(std::string_view name, const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", name, what));
}

void check_sizes(const IndexedMesh& mesh, std::string_view source) {
  if (mesh.positions.size() > kMaxVertices)
    refuse(source, fmt::format("expected at most {} vertices, found {}", kMaxVertices,
                               mesh.positions.size()));
  if (mesh.faces.size() > kMaxFaces)
    refuse(source,
           fmt::format("expected at most {} faces, found {}", kMaxFaces, mesh.faces.size()));
  if (mesh.faces.empty()) refuse(source, "expected at least one face, found none");
}

void check_elements(const IndexedMesh& mesh, const MeshSource& source) {
  for_parts(mesh.positions.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t vertex = first; vertex < last; ++vertex) {
      const Vector3<double>& p = mesh.positions[vertex];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        refuse(source.name(),
               fmt::format("vertex {}: expected a finite position, found ({}, {}, {})", vertex, p.x,
                           p.y, p.z));
    }
  });
  check_faces(mesh.faces, mesh.positions.size(), source);
}

/// Removes the vertices without a corner and renumbers the others. Returns the former numbers of
/// those that stay.
std::vector<VertexId> drop_unused_vertices(IndexedMesh& mesh,
                                           std::vector<FaceSide>& vertex_corners) {
  std::vector<VertexId> renumbered(vertex_corners.size()), former;
  VertexId kept = 0;
  for (std::size_t vertex = 0; vertex < vertex_corners.size(); ++vertex) {
    renumbered[vertex] = kept;
    if (!vertex_corners[vertex].exists()) continue;
    vertex_corners[kept] = vertex_corners[vertex];
    mesh.positions[kept] = mesh.positions[vertex];
    former.push_back(static_cast<VertexId>(vertex));
    ++kept;
  }
  vertex_corners.resize(kept);
  mesh.positions.resize(kept);
  mesh.positions.shrink_to_fit();
  for (FaceVertices& face : mesh.faces)
    for (VertexId& vertex : face) vertex = renumbered[vertex];
  former.shrink_to_fit();
  return former;
}

std::vector<EdgeId> find_border_edges(std::span<const Edge> edges, std::uint64_t count) {
  std::vector<EdgeId> result;
  if (count == 0) return result;
  result.reserve(count);
  for (EdgeId edge = 0; edge < edges.size(); ++edge)
    if (edges[edge].is_border()) result.push_back(edge);
  return result;
}

void warn(std::vector<std::string>* warnings, std::string text) {
  if (warnings != nullptr) warnings->push_back(std::move(text));
}

}  // namespace

BaseMesh BaseMesh::build(IndexedMesh mesh, std::string_view source,
                         std::vector<std::string>* warnings) try {
  const MeshSource names(source, mesh.cut_faces);
  check_sizes(mesh, source);
  check_elements(mesh, names);

  BaseMesh result;
  MatchedSides sides = match_sides(mesh.faces, mesh.positions.size(), names);
  if (!sides.oriented) {
    for (const FaceVertices& face : mesh.faces) result.input_faces_.push_back(face[1]);
    const std::uint64_t flipped = make_orientation_consistent(mesh.faces, sides.twins, names);
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
      std::uint32_t& entry = result.input_faces_[face];
      entry = 2 * face + (mesh.faces[face][1] != entry ? 1 : 0);
    }
    warn(warnings, fmt::format("{}: {} of {} faces flipped to the orientation of the first face of "
                               "their component",
                               source, flipped, names.face_count(mesh.faces.size())));
  }

  result.vertex_corners_ =
      find_vertex_corners(mesh.faces, sides.twins, mesh.positions.size(), names);
  result.input_vertex_count_ = mesh.positions.size();
  // Unused vertices are dropped only here, so that all messages above name vertices as the input
  // does.
  if (std::find(result.vertex_corners_.begin(), result.vertex_corners_.end(), FaceSide()) !=
      result.vertex_corners_.end()) {
    const std::size_t before = mesh.positions.size();
    result.input_vertices_ = drop_unused_vertices(mesh, result.vertex_corners_);
    warn(warnings, fmt::format("{}: {} of {} vertices dropped: no face uses them", source,
                               before - result.input_vertices_.size(), before));
  }
  result.positions_ = std::move(mesh.positions);
  result.faces_ = std::move(mesh.faces);
  result.edges_ = number_edges(result.faces_, sides.twins, sides.border_count);
  result.face_edges_ = std::move(sides.twins);
  result.border_edges_ = find_border_edges(result.edges_, sides.border_count);
  result.slot_shapes_ = std::make_shared<const SlotShapes>(result.topology());
  return result;
} catch (const std::bad_alloc&) {
  throw out_of_memory(std::string(source));
}

BaseMesh BaseMesh::with_face_order(std::span<const FaceId> order) const {
  std::vector<FaceId> renumbered(faces_.size(), kNoId);
  if (order.size() != faces_.size())
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("reorder faces: expected {} faces, found {}", faces_.size(), order.size()));
  for (FaceId face = 0; face < order.size(); ++face) {
    if (order[face] >= faces_.size() || renumbered[order[face]] != kNoId)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("reorder faces: entry {}: expected a face that is not yet placed, "
                              "found {}",
                              face, order[face]));
    renumbered[order[face]] = face;
  }
  const auto moved = [&](FaceSide side) {
    return side.exists() ? FaceSide(renumbered[side.face()], side.side()) : FaceSide();
  };

  BaseMesh result;
  result.positions_ = positions_;
  result.input_vertices_ = input_vertices_;
  result.input_vertex_count_ = input_vertex_count_;
  result.input_faces_.resize(faces_.size());
  result.faces_.resize(faces_.size());
  result.face_edges_.resize(faces_.size());
  result.edges_.resize(edges_.size());
  result.vertex_corners_.resize(vertex_corners_.size());
  for_parts(faces_.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face) {
      result.faces_[face] = faces_[order[face]];
      result.face_edges_[face] = face_edges_[order[face]];
      result.input_faces_[face] =
          input_faces_.empty() ? 2 * order[face] : input_faces_[order[face]];
    }
  });
  // One thread does this: which use of an edge is the first depends on all faces before it.
  std::vector<EdgeId> edge_renumbered(edges_.size(), kNoId), old_edges;
  old_edges.reserve(edges_.size());
  for (const std::array<EdgeId, 3>& sides : result.face_edges_)
    for (const std::size_t side : {2u, 0u, 1u}) {
      EdgeId& edge = edge_renumbered[sides[side]];
      if (edge != kNoId) continue;
      edge = static_cast<EdgeId>(old_edges.size());
      old_edges.push_back(sides[side]);
    }
  for_parts(edges_.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t edge = first; edge < last; ++edge) {
      const Edge& old = edges_[old_edges[edge]];
      result.edges_[edge] = {old.start, old.end, moved(old.own), moved(old.other)};
    }
  });
  for_parts(faces_.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face)
      for (EdgeId& edge : result.face_edges_[face]) edge = edge_renumbered[edge];
  });
  for_parts(vertex_corners_.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t vertex = first; vertex < last; ++vertex)
      result.vertex_corners_[vertex] = moved(vertex_corners_[vertex]);
  });
  result.border_edges_ = find_border_edges(result.edges_, border_edges_.size());
  result.slot_shapes_ = std::make_shared<const SlotShapes>(result.topology());
  return result;
}

LevelGeometry BaseMesh::geometry(BaseRelativeLevel level, std::size_t record_bytes,
                                 std::uint64_t block_bytes) const {
  return {slot_shapes_ ? *slot_shapes_ : SlotShapes(), level, record_bytes, block_bytes};
}

std::uint64_t BaseMesh::memory_bytes() const {
  const auto bytes = [](const auto& array) { return array.capacity() * sizeof(array[0]); };
  return bytes(positions_) + bytes(faces_) + bytes(face_edges_) + bytes(edges_) +
         bytes(vertex_corners_) + bytes(border_edges_) +
         (slot_shapes_ ? slot_shapes_->memory_bytes() : 0) + bytes(input_vertices_) +
         bytes(input_faces_);
}

PLAIT_END_NAMESPACE
