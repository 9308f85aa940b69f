// plait/base_mesh.h: the irregular triangle mesh whose faces are refined, in memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

class LevelGeometry;
class SlotShapes;
struct BaseRelativeLevel;

/// A face of a file that has more than three corners, and is several triangles here.
struct CutFace {
  FaceId first_triangle;
  std::uint32_t triangles;
  FaceId number;  ///< of the face in the file, from 0
};

/// Triangles as read from a file. They may be invalid.
struct IndexedMesh {
  std::vector<Vector3<double>> positions;
  std::vector<std::array<VertexId, 3>> faces;
  /// Ascending. Messages of BaseMesh::build() name the faces of the file by them.
  std::vector<CutFace> cut_faces = {};
};

/// Where the vertices and faces of a BaseMesh are in the mesh that BaseMesh::build() got, and the
/// other way round. So a program finds its own arrays and materials again after build(),
/// with_face_order(), lay_out() and rebase(), and in a store that it opens later.
struct InputMaps {
  /// [vertex] its number in the input; kNoId for a vertex that rebase() made.
  std::vector<VertexId> input_vertices;
  /// [face] the face of the input that it is, or that rebase() has divided into it and others.
  std::vector<FaceId> input_faces;
  /// [face] whether build() has exchanged the second and the third corner of the input's face.
  std::vector<bool> turned;
  std::uint64_t input_vertex_count = 0;
  /// [vertex of the input] its number now; kNoId for a vertex that build() dropped.
  std::vector<VertexId> vertices;
  /// [face of the input] its number now; of several faces that rebase() made of it, the first one.
  std::vector<FaceId> faces;
};

/// An oriented 2-manifold with or without border, of any genus, with any number of components.
/// Immutable. Threads: shared (docs/threads.md).
class BaseMesh {
 public:
  BaseMesh() = default;

  /// Builds the connectivity of `mesh` in O(V + F + sum of d log d) for valences d.
  /// Faces keep their order and their rotation; edges are numbered by first use (face by face,
  /// sides 2, 0, 1: ab, bc, ca). build() drops vertices that no face uses. If the faces of a
  /// component disagree in orientation, build() flips faces to the orientation of the component's
  /// first face. Each of these two changes adds a line to `warnings`, if the caller gave
  /// `warnings`; input_maps() has them in full. `source` (a file name) begins every error message.
  /// Errors: kInvalidArgument naming the first bad element: an index out of range, a position that
  /// is not finite, a face that names a vertex twice, an edge of more than two faces, a vertex
  /// whose faces form more than one fan, a face given twice, an orientation that cannot be made
  /// consistent, no face at all, more than 2^30 faces or 2^32 - 2 vertices. Messages name vertices
  /// as `mesh` numbers them, and faces as the file does (IndexedMesh::cut_faces).
  static BaseMesh build(IndexedMesh mesh, std::string_view source = "mesh",
                        std::vector<std::string>* warnings = nullptr);

  /// The same mesh with its faces in the given order (order[new] = old) and its edges renumbered by
  /// first use. Vertices, face rotations and edge frames do not change, so slot contents do not
  /// change either.
  /// O(F). Errors: kInvalidArgument if `order` is no permutation of the faces.
  BaseMesh with_face_order(std::span<const FaceId> order) const;

  /// Where everything was in the mesh that build() got. Errors: kOutOfMemory.
  InputMaps input_maps() const;
  /// Whether input_maps() has another number for any vertex or face than the one that it has now,
  /// or a face that build() turned.
  bool differs_from_input() const { return !input_vertices_.empty() || !input_faces_.empty(); }
  /// The same mesh with other maps, for code that makes a mesh from another one or from a file.
  /// Ignores `maps.vertices` and `maps.faces`, which follow from the others. Errors:
  /// kInvalidArgument unless there is an entry for each vertex and face of this mesh, and each
  /// entry is a vertex below input_vertex_count, kNoId, or a face below face_count().
  BaseMesh with_input_maps(const InputMaps& maps) &&;

  std::uint64_t vertex_count() const { return positions_.size(); }
  std::uint64_t edge_count() const { return edges_.size(); }
  std::uint64_t face_count() const { return faces_.size(); }
  std::uint64_t border_edge_count() const { return border_edges_.size(); }
  /// Where the slots and blocks of a level are. All geometries of a store's levels come from here,
  /// by StoreAccess::geometry(), so only this function knows which slots a level has: today all,
  /// whole but for border edges. Errors: those of LevelGeometry.
  LevelGeometry geometry(BaseRelativeLevel level, std::size_t record_bytes,
                         std::uint64_t block_bytes) const;

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
  std::shared_ptr<const SlotShapes> slot_shapes_;  ///< nullptr: of no edge
  std::vector<VertexId> input_vertices_;  ///< as in InputMaps; empty if no vertex was renumbered
  std::uint64_t input_vertex_count_ = 0;
  /// [face] twice its number in the input, plus one if build() turned it; empty if nothing changed.
  std::vector<std::uint32_t> input_faces_;
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
