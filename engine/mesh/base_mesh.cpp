#include "plait/base_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/connectivity.h"
#include "mesh/mesh_region.h"
#include "mesh/parallel_parts.h"
#include "plait/detail/face_depths.h"
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

std::string dropped_vertices_text(std::string_view source, std::uint64_t dropped,
                                  std::uint64_t all) {
  return fmt::format("{}: {} of {} vertices dropped: no face uses them", source, dropped, all);
}

struct BaseMesh::OwnedArrays {
  std::vector<Vector3<double>> positions;
  std::vector<std::array<VertexId, 3>> faces;
  std::vector<std::array<EdgeId, 3>> face_edges;
  std::vector<Edge> edges;
  std::vector<FaceSide> vertex_corners;
  std::vector<EdgeId> border_edges;
  std::vector<VertexId> input_vertices;
  std::vector<std::uint32_t> input_faces;
};

BaseMesh::BaseMesh(BaseMesh&& other) noexcept
    : arrays_(std::exchange(other.arrays_, {})),
      owner_(std::move(other.owner_)),
      maps_owner_(std::move(other.maps_owner_)),
      pages_(std::move(other.pages_)),
      slot_shapes_(std::move(other.slot_shapes_)),
      depths_(std::move(other.depths_)),
      region_(std::move(other.region_)),
      piece_bytes_(std::exchange(other.piece_bytes_, 0)) {}

BaseMesh& BaseMesh::operator=(BaseMesh&& other) noexcept {
  if (this == &other) return *this;
  arrays_ = std::exchange(other.arrays_, {});
  owner_ = std::move(other.owner_);
  maps_owner_ = std::move(other.maps_owner_);
  pages_ = std::move(other.pages_);
  slot_shapes_ = std::move(other.slot_shapes_);
  depths_ = std::move(other.depths_);
  region_ = std::move(other.region_);
  piece_bytes_ = std::exchange(other.piece_bytes_, 0);
  return *this;
}

BaseMesh BaseMesh::of(std::shared_ptr<const OwnedArrays> made, std::uint64_t input_vertex_count) {
  BaseMesh result;
  result.arrays_ = {
      made->positions,
      {made->faces, made->face_edges, made->edges, made->vertex_corners, made->border_edges},
      made->input_vertices,
      made->input_faces,
      input_vertex_count};
  result.slot_shapes_ = std::make_shared<const SlotShapes>(result.arrays_.mesh);
  result.owner_ = std::move(made);
  return result;
}

BaseMesh BaseMesh::of(std::shared_ptr<const MeshPages> pages) {
  BaseMesh result;
  result.arrays_ = pages->arrays();
  pages->need(MeshArray::kBorderEdges);
  result.slot_shapes_ = std::make_shared<const SlotShapes>(result.arrays_.mesh);
  result.pages_ = std::move(pages);
  return result;
}

BaseMesh BaseMesh::build(IndexedMesh mesh, std::string_view source,
                         std::vector<std::string>* warnings) try {
  const MeshSource names(source, mesh.cut_faces);
  check_sizes(mesh, source);
  check_elements(mesh, names);

  const auto result = std::make_shared<OwnedArrays>();
  MatchedSides sides = match_sides(mesh.faces, mesh.positions.size(), names);
  if (!sides.oriented) {
    for (const FaceVertices& face : mesh.faces) result->input_faces.push_back(face[1]);
    const std::uint64_t flipped = make_orientation_consistent(mesh.faces, sides.twins, names);
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
      std::uint32_t& entry = result->input_faces[face];
      entry = 2 * face + (mesh.faces[face][1] != entry ? 1 : 0);
    }
    warn(warnings, fmt::format("{}: {} of {} faces flipped to the orientation of the first face of "
                               "their component",
                               source, flipped, names.face_count(mesh.faces.size())));
  }

  result->vertex_corners =
      find_vertex_corners(mesh.faces, sides.twins, mesh.positions.size(), names);
  const std::uint64_t input_vertex_count = mesh.positions.size();
  // Unused vertices are dropped only here, so that all messages above name vertices as the input
  // does.
  if (std::find(result->vertex_corners.begin(), result->vertex_corners.end(), FaceSide()) !=
      result->vertex_corners.end()) {
    const std::size_t before = mesh.positions.size();
    result->input_vertices = drop_unused_vertices(mesh, result->vertex_corners);
    warn(warnings, dropped_vertices_text(source, before - result->input_vertices.size(), before));
  }
  result->positions = std::move(mesh.positions);
  result->faces = std::move(mesh.faces);
  result->edges = number_edges(result->faces, sides.twins, sides.border_count);
  result->face_edges = std::move(sides.twins);
  result->border_edges = find_border_edges(result->edges, sides.border_count);
  return of(result, input_vertex_count);
} catch (const std::bad_alloc&) {
  throw out_of_memory(std::string(source));
}

BaseMesh BaseMesh::with_face_order(std::span<const FaceId> order) const {
  const MeshArrays& arrays = all_arrays();
  const Topology& mesh = arrays.mesh;
  std::vector<FaceId> renumbered(mesh.faces.size(), kNoId);
  if (order.size() != mesh.faces.size())
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("reorder faces: expected {} faces, found {}", mesh.faces.size(), order.size()));
  for (FaceId face = 0; face < order.size(); ++face) {
    if (order[face] >= mesh.faces.size() || renumbered[order[face]] != kNoId)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("reorder faces: entry {}: expected a face that is not yet placed, "
                              "found {}",
                              face, order[face]));
    renumbered[order[face]] = face;
  }
  const auto moved = [&](FaceSide side) {
    return side.exists() ? FaceSide(renumbered[side.face()], side.side()) : FaceSide();
  };

  const auto result = std::make_shared<OwnedArrays>();
  result->positions.assign(arrays.positions.begin(), arrays.positions.end());
  result->input_vertices.assign(arrays.input_vertices.begin(), arrays.input_vertices.end());
  result->input_faces.resize(mesh.faces.size());
  result->faces.resize(mesh.faces.size());
  result->face_edges.resize(mesh.faces.size());
  result->edges.resize(mesh.edges.size());
  result->vertex_corners.resize(mesh.vertex_corners.size());
  for_parts(mesh.faces.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face) {
      result->faces[face] = mesh.faces[order[face]];
      result->face_edges[face] = mesh.face_edges[order[face]];
      result->input_faces[face] =
          arrays.input_faces.empty() ? 2 * order[face] : arrays.input_faces[order[face]];
    }
  });
  // One thread does this: which use of an edge is the first depends on all faces before it.
  std::vector<EdgeId> edge_renumbered(mesh.edges.size(), kNoId), old_edges;
  old_edges.reserve(mesh.edges.size());
  for (const std::array<EdgeId, 3>& sides : result->face_edges)
    for (const std::size_t side : {2u, 0u, 1u}) {
      EdgeId& edge = edge_renumbered[sides[side]];
      if (edge != kNoId) continue;
      edge = static_cast<EdgeId>(old_edges.size());
      old_edges.push_back(sides[side]);
    }
  for_parts(mesh.edges.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t edge = first; edge < last; ++edge) {
      const Edge& old = mesh.edges[old_edges[edge]];
      result->edges[edge] = {old.start, old.end, moved(old.own), moved(old.other)};
    }
  });
  for_parts(mesh.faces.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face)
      for (EdgeId& edge : result->face_edges[face]) edge = edge_renumbered[edge];
  });
  for_parts(mesh.vertex_corners.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t vertex = first; vertex < last; ++vertex)
      result->vertex_corners[vertex] = moved(mesh.vertex_corners[vertex]);
  });
  result->border_edges = find_border_edges(result->edges, mesh.border_edges.size());
  return of(result, arrays.input_vertex_count);
}

BaseMesh BaseMesh::with_depths(std::vector<std::uint8_t> depths) const {
  BaseMesh result = *this;
  result.depths_ = std::make_shared<const FaceDepths>(topology(), std::move(depths));
  return result;
}

BaseMesh BaseMesh::without_depths() const {
  BaseMesh result = *this;
  result.depths_ = nullptr;
  return result;
}

BaseMesh BaseMesh::around(EdgeId first, EdgeId after) const {
  BaseMesh result = *this;
  result.region_ =
      std::make_shared<const MeshRegion>(find_region(arrays_, pages_.get(), first, after));
  if (pages_) pages_->need_elements(MeshArray::kPositions, result.region_->neighbours);
  return result;
}

BaseMesh BaseMesh::in_pieces(std::uint64_t bytes) const {
  BaseMesh result = *this;
  if (pages_) result.piece_bytes_ = bytes;
  return result;
}

LevelGeometry BaseMesh::geometry(BaseRelativeLevel level, std::size_t record_bytes,
                                 std::uint64_t block_bytes) const {
  if (depths_) return {depths_->shapes(level), level, record_bytes, block_bytes};
  return {slot_shapes_ ? *slot_shapes_ : SlotShapes(), level, record_bytes, block_bytes};
}

const MeshArrays& BaseMesh::all_arrays() const {
  if (!pages_) return arrays_;
  pages_->need_topology();
  for (const MeshArray array :
       {MeshArray::kPositions, MeshArray::kInputVertices, MeshArray::kInputFaces})
    pages_->need(array);
  return arrays_;
}

std::uint64_t BaseMesh::memory_bytes() const {
  const std::uint64_t shapes =
      (slot_shapes_ ? slot_shapes_->memory_bytes() : 0) + (depths_ ? depths_->memory_bytes() : 0);
  if (pages_) return pages_->memory_bytes() + shapes;
  return arrays_.positions.size_bytes() + arrays_.mesh.faces.size_bytes() +
         arrays_.mesh.face_edges.size_bytes() + arrays_.mesh.edges.size_bytes() +
         arrays_.mesh.vertex_corners.size_bytes() + arrays_.mesh.border_edges.size_bytes() +
         arrays_.input_vertices.size_bytes() + arrays_.input_faces.size_bytes() + shapes;
}

PLAIT_END_NAMESPACE
