// connectivity.h: the steps that turn a list of triangles into an oriented 2-manifold. Pure
// functions over the caller's arrays. BaseMesh::build calls them in the order of this file.
//
// A half-edge is one side of one face, coded as FaceSide. Its twin is the half-edge of the face
// across the same edge, kNoId on a border.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh_source.h"
#include "plait/error.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using FaceVertices = std::array<VertexId, 3>;
using SideCodes = std::array<std::uint32_t, 3>;

constexpr std::uint64_t kMaxFaces = std::uint64_t{1} << 30;
/// All vertex indices are below kNoId.
constexpr std::uint64_t kMaxVertices = kNoId - 1;

/// The vertex at which a half-edge starts, in the orientation of its own face.
inline VertexId start_vertex(std::span<const FaceVertices> faces, FaceSide half_edge) {
  return faces[half_edge.face()][static_cast<std::size_t>((half_edge.side() + 1) % 3)];
}

inline VertexId opposite_vertex(std::span<const FaceVertices> faces, FaceSide half_edge) {
  return faces[half_edge.face()][static_cast<std::size_t>(half_edge.side())];
}

inline FaceSide from_code(std::uint32_t code) {
  FaceSide side;
  side.code = code;
  return side;
}

/// The order in which the sides of a face number edges: ab, bc, ca.
constexpr std::array<int, 3> kSideOrder = {2, 0, 1};

/// The edge of a side that runs from `start` to `end`, and of the one beyond it.
inline Edge edge_of(VertexId start, VertexId end, FaceSide here, FaceSide beyond) {
  if (!beyond.exists() || start < end) return {start, end, here, beyond};
  return {end, start, beyond, here};
}

/// The corner of smallest rank is the first one of a fan. `next` is the vertex of the face's next
/// corner.
inline std::uint32_t fan_rank(bool after_border, VertexId next) {
  return after_border ? 0 : 1 + next;
}

// What is wrong with a mesh. Faces have the numbers of the file.

/// At most three of the faces are named.
Error too_many_faces_at_edge(std::string_view source, VertexId low, VertexId high,
                             std::span<const std::uint64_t, 3> first_faces, std::uint64_t count);
Error copied_face(std::string_view source, std::uint64_t face, std::uint64_t copied);
Error more_than_one_fan(std::string_view source, VertexId vertex, std::uint64_t face_count,
                        std::uint64_t faces_of_fan, std::uint64_t face_of_fan);
std::string dropped_vertices_text(std::string_view source, std::uint64_t dropped,
                                  std::uint64_t all);
Error repeated_corner(std::string_view source, std::uint64_t face, const FaceVertices& corners);

/// Errors: kInvalidArgument for an index of `vertex_count` or more, and for a face that names a
/// vertex twice.
void check_faces(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                 const MeshSource& source);

struct MatchedSides {
  std::vector<SideCodes> twins;  ///< [face][side]
  std::uint64_t border_count = 0;
  bool oriented = true;  ///< the two half-edges of every pair run in opposite directions
  /// Every vertex has a plain fan, so find_vertex_corners() would find no error.
  bool has_plain_fans = true;
};

/// The faces of a vertex are a plain fan if they follow each other counterclockwise around it, all
/// of them, at most this number, and no neighbour is there twice. Most vertices have one.
constexpr std::size_t kMostInPlainFan = 32;

/// Finds all twins: sorts the corners by their vertices, and then compares the sides at each vertex
/// with each other. O(V + F + sum of d log d); 12 F + 4 V bytes of memory beside the result. `room`
/// becomes the result if its size fits.
/// REQUIRES: indices below `vertex_count`, three different ones per face.
/// Errors: kInvalidArgument for an edge of more than two faces, and for a face given twice.
MatchedSides match_sides(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                         const MeshSource& source, std::vector<SideCodes> room = {});

/// The vertices that have faces but no plain fan, ascending. O(V + F); 12 F + 4 V bytes of memory.
/// REQUIRES: indices below `vertex_count`.
std::vector<VertexId> without_plain_fan(std::span<const FaceVertices> faces,
                                        std::uint64_t vertex_count);

/// What the refusal of a mesh that is no manifold says at its end: which commands take such a mesh.
constexpr std::string_view kRepairAdvice =
    "; plait check counts such places, and plait remesh repairs them";

/// Flips faces (corner 0 stays) until each agrees with the first face of its component. Returns the
/// number of flipped faces of the file.
/// Errors: kInvalidArgument for a component with only one side.
std::uint64_t make_orientation_consistent(std::span<FaceVertices> faces, std::span<SideCodes> twins,
                                          const MeshSource& source);

/// Topology::vertex_corners; a vertex that no face uses gets none. O(V + F) for any valence.
/// REQUIRES: oriented faces.
/// Errors: kInvalidArgument for a vertex whose faces form more than one fan.
std::vector<FaceSide> find_vertex_corners(std::span<const FaceVertices> faces,
                                          std::span<const SideCodes> twins,
                                          std::uint64_t vertex_count, const MeshSource& source);

/// Numbers the edges by first use and replaces each twin by its edge. Returns the edges.
/// REQUIRES: oriented faces.
std::vector<Edge> number_edges(std::span<const FaceVertices> faces, std::span<SideCodes> twins,
                               std::uint64_t border_count);

PLAIT_END_NAMESPACE
