// plait/base_mesh.h: the irregular triangle mesh whose faces are refined, in memory.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/namespace.h"
#include "plait/slot_shapes.h"
#include "plait/topology.h"
#include "plait/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// Triangles as read from a file. They may be invalid.
struct IndexedMesh {
  std::vector<Vector3<double>> positions;
  std::vector<std::array<VertexId, 3>> faces;
};

/// An oriented 2-manifold with or without border, of any genus, with any number of components.
/// Immutable and safe to read from any number of threads.
class BaseMesh {
 public:
  BaseMesh() = default;

  /// Builds the connectivity of `mesh` in O(V + F + sum of d log d) for valences d.
  /// Faces keep their order and their rotation; edges are numbered by first use (face by face,
  /// sides 2, 0, 1: ab, bc, ca). build() drops vertices that no face uses. If the faces of a
  /// component disagree in orientation, build() flips faces to the orientation of the component's
  /// first face. Each of these two changes adds a line to `warnings`, if the caller gave
  /// `warnings`. `source` (a file name) begins every error message.
  /// Errors: kInvalidArgument naming the first bad element: an index out of range, a position that
  /// is not finite, a face that names a vertex twice, an edge of more than two faces, a vertex
  /// whose faces form more than one fan, a face given twice, an orientation that cannot be made
  /// consistent, no face at all, more than 2^30 faces or 2^32 - 2 vertices. Messages name vertices
  /// and faces as `mesh` numbers them.
  static BaseMesh build(IndexedMesh mesh, std::string_view source = "mesh",
                        std::vector<std::string>* warnings = nullptr);

  /// The same mesh with its faces in the given order (order[new] = old) and its edges renumbered by
  /// first use. Vertices, face rotations and edge frames do not change, so slot contents do not
  /// change either.
  /// O(F). Errors: kInvalidArgument if `order` is no permutation of the faces.
  BaseMesh with_face_order(std::span<const FaceId> order) const;

  std::uint64_t vertex_count() const { return positions_.size(); }
  std::uint64_t edge_count() const { return edges_.size(); }
  std::uint64_t face_count() const { return faces_.size(); }
  std::uint64_t border_edge_count() const { return border_edges_.size(); }
  /// The shapes of the edges' slots, which are the same on every level: half for a border edge,
  /// whole for all others.
  const SlotShapes& slot_shapes() const { return slot_shapes_; }

  std::span<const Vector3<double>> positions() const { return positions_; }
  std::span<const Edge> edges() const { return edges_; }
  std::span<const EdgeId> border_edges() const { return border_edges_; }
  std::span<const std::array<VertexId, 3>> faces() const { return faces_; }
  std::span<const std::array<EdgeId, 3>> face_edges() const { return face_edges_; }

  /// The result refers to arrays of this object. The result is valid while the object lives and is
  /// not moved from.
  Topology topology() const {
    return {faces_, face_edges_, edges_, vertex_corners_, border_edges_};
  }

  /// Bytes of heap memory that this object holds.
  std::uint64_t memory_bytes() const;

 private:
  std::vector<Vector3<double>> positions_;
  std::vector<std::array<VertexId, 3>> faces_;
  std::vector<std::array<EdgeId, 3>> face_edges_;
  std::vector<Edge> edges_;
  std::vector<FaceSide> vertex_corners_;
  std::vector<EdgeId> border_edges_;
  SlotShapes slot_shapes_;
};

/// Vertices, edges and faces at a level of refinement. One refinement gives V' = V + E, E' = 2E +
/// 3F and F' = 4F, for meshes with and without border.
/// Errors: kInvalidArgument for a level outside 0 to kMaxLevel, or a count of 2^64 or more.
/// Pinned by tests/engine/mesh/base_mesh_test.cpp, CountsAtLevel.
struct LevelCounts {
  std::uint64_t vertices, edges, faces;
};
LevelCounts counts_at_level(const BaseMesh& mesh, int level);

PLAIT_END_NAMESPACE
