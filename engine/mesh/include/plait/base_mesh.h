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

class FaceDepths;
class File;
class LevelGeometry;
class SlotShapes;
struct BaseRelativeLevel;
struct MeshRegion;

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

/// The arrays, in the order in which the file base.index has them.
enum class MeshArray : std::uint8_t {
  kPositions,
  kFaces,
  kFaceEdges,
  kEdges,
  kVertexCorners,
  kBorderEdges,
  kInputVertices,
  kInputFaces,
};

/// The arrays of a base mesh, wherever they lie: in a BaseMesh that has computed them, or in memory
/// that its MeshPages fill. They live as long as those.
struct MeshArrays {
  std::span<const Vector3<double>> positions = {};
  Topology mesh = {};
  /// As in InputMaps; empty if no vertex was renumbered.
  std::span<const VertexId> input_vertices = {};
  /// [face] twice its number in the input, plus one if BaseMesh::build() turned it; empty if
  /// nothing changed.
  std::span<const std::uint32_t> input_faces = {};
  std::uint64_t input_vertex_count = 0;
};

/// Files that have exactly what a store writes of a mesh; nullptr: there is none. They live as long
/// as the mesh.
struct StoredBase {
  const File* mesh = nullptr;   ///< base.mesh
  const File* index = nullptr;  ///< base.index, which follows from it
  std::uint64_t mesh_checksum = 0;
};

/// The arrays of a mesh that are read by pages. The spans of arrays() have their sizes and their
/// addresses from the start. What the other functions are asked for is there when they return, is
/// checked, and never changes again: a number in it is below the count of what it refers to.
/// Threads: any number. Errors: kCorruption, kIo.
class MeshPages {
 public:
  virtual ~MeshPages() = default;
  virtual const MeshArrays& arrays() const noexcept = 0;
  virtual void need(MeshArray array) const = 0;
  /// All that Topology has. Its arrays also agree with each other: each side of a face is a side of
  /// its edge and runs between its vertices, and each vertex is at its corner. So a walk around a
  /// vertex comes to a border or back.
  virtual void need_topology() const = 0;
  /// The corners of one face, its edges, and the entries of these.
  virtual void need_face(FaceId face) const = 0;
  /// Single entries of an array. They alone are checked, not what they have to do with others.
  virtual void need_elements(MeshArray array, std::span<const std::uint32_t> elements) const = 0;
  /// The entries from `first` on, before `after`, checked likewise.
  virtual void need_range(MeshArray array, std::uint64_t first, std::uint64_t after) const = 0;
  /// That the sides of these faces are sides of their edges. REQUIRES: these entries were needed.
  virtual void check_sides(std::span<const FaceId> faces) const = 0;
  /// Throws kCorruption, which names the file and the place of the entry.
  [[noreturn]] virtual void refuse(MeshArray array, std::uint64_t element,
                                   const std::string& what) const = 0;
  /// Of what was read until now.
  virtual std::uint64_t memory_bytes() const noexcept = 0;
  /// Gives back the memory of the pages of these entries. They are read, and checked, again when
  /// they are needed. REQUIRES: nobody uses entries of the array.
  virtual void forget(MeshArray array, std::uint64_t first, std::uint64_t after) const = 0;
  virtual StoredBase stored() const noexcept { return {}; }
};

/// An oriented 2-manifold with or without border, of any genus, with any number of components.
/// Immutable; copies share their arrays. Threads: shared (docs/threads.md).
///
/// The mesh of a store that has the file base.index (docs/format.md) reads its arrays from there,
/// and checks them, when they are asked for. So every function that returns an array, maps or a
/// Topology may read the disk in its first call. Errors of such a mesh: kCorruption for a damaged
/// file; kIo.
class BaseMesh {
 public:
  BaseMesh() = default;
  BaseMesh(const BaseMesh&) = default;
  BaseMesh& operator=(const BaseMesh&) = default;
  BaseMesh(BaseMesh&& other) noexcept;
  BaseMesh& operator=(BaseMesh&& other) noexcept;
  ~BaseMesh() = default;
  /// A mesh whose arrays are read by pages; for the store.
  static BaseMesh of(std::shared_ptr<const MeshPages> pages);

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
  bool differs_from_input() const {
    return !arrays_.input_vertices.empty() || !arrays_.input_faces.empty();
  }
  /// The same mesh with other maps, for code that makes a mesh from another one or from a file.
  /// Ignores `maps.vertices` and `maps.faces`, which follow from the others. Errors:
  /// kInvalidArgument unless there is an entry for each vertex and face of this mesh, and each
  /// entry is a vertex below input_vertex_count, kNoId, or a face below face_count().
  BaseMesh with_input_maps(const InputMaps& maps) &&;

  /// The same mesh whose faces are refined to depths of their own (docs/adaptive.md): [face] how
  /// often this mesh is refined there. Reads the edges. Errors: kInvalidArgument unless there is
  /// one depth for each face, 0 to 20.
  BaseMesh with_depths(std::vector<std::uint8_t> depths) const;
  /// The same mesh whose faces have all levels.
  BaseMesh without_depths() const;
  /// nullptr for a mesh whose faces have all levels. build(), with_face_order() and rebase() make
  /// such meshes.
  const FaceDepths* depths() const noexcept { return depths_.get(); }

  /// The same mesh, of which no more is read than the slots of these edges follow from by stencils
  /// of one ring (mesh/mesh_region.h): topology() then is to be used there alone, and of
  /// arrays().positions those of the region. All other functions work as before. For the store of
  /// one part. REQUIRES: first < after <= edge_count(). Errors: kOutOfMemory.
  BaseMesh around(EdgeId first, EdgeId after) const;
  /// nullptr but for the result of around().
  const MeshRegion* region() const noexcept { return region_.get(); }

  /// The same mesh for works that can take it in pieces (mesh/mesh_piece.h): they then read a piece
  /// at a time, and have about `bytes` of the mesh in memory. All functions work as before.
  /// Does nothing for a mesh that is in memory.
  BaseMesh in_pieces(std::uint64_t bytes) const;
  /// 0: works take the mesh as a whole.
  std::uint64_t piece_bytes() const noexcept { return piece_bytes_; }
  /// nullptr for a mesh in memory.
  const MeshPages* pages() const noexcept { return pages_.get(); }

  /// What a new store of this mesh may copy instead of writing it.
  StoredBase stored_base() const noexcept {
    return pages_ && !maps_owner_ ? pages_->stored() : StoredBase();
  }

  std::uint64_t vertex_count() const { return arrays_.positions.size(); }
  std::uint64_t edge_count() const { return arrays_.mesh.edges.size(); }
  std::uint64_t face_count() const { return arrays_.mesh.faces.size(); }
  std::uint64_t border_edge_count() const { return arrays_.mesh.border_edges.size(); }
  /// Where the slots and blocks of a level are. All geometries of a store's levels come from here,
  /// by StoreAccess::geometry(), so only this function knows which slots a level has: all, whole
  /// but for border edges, unless there are depths(). Errors: those of LevelGeometry.
  LevelGeometry geometry(BaseRelativeLevel level, std::size_t record_bytes,
                         std::uint64_t block_bytes) const;

  std::span<const Vector3<double>> positions() const {
    return needed(MeshArray::kPositions).positions;
  }
  std::span<const Edge> edges() const { return needed(MeshArray::kEdges).mesh.edges; }
  std::span<const EdgeId> border_edges() const {
    return needed(MeshArray::kBorderEdges).mesh.border_edges;
  }
  std::span<const std::array<VertexId, 3>> faces() const {
    return needed(MeshArray::kFaces).mesh.faces;
  }
  std::span<const std::array<EdgeId, 3>> face_edges() const {
    return needed(MeshArray::kFaceEdges).mesh.face_edges;
  }

  /// The result refers to arrays of this object. The result is valid while the object lives and is
  /// not moved from.
  Topology topology() const {
    if (pages_ && !region_) pages_->need_topology();
    return arrays_.mesh;
  }
  /// All arrays, as they are in memory now. Only what was asked for may be read: by need_face(), or
  /// by the functions above.
  const MeshArrays& arrays() const { return arrays_; }
  /// All arrays, to be read.
  const MeshArrays& all_arrays() const;
  /// Lets arrays() be read for one face: its corners, its edges, and these edges' entries.
  /// REQUIRES: face < face_count().
  void need_face(FaceId face) const {
    if (pages_) pages_->need_face(face);
  }

  /// Bytes of heap memory that this object holds, or of the pages that it has read.
  std::uint64_t memory_bytes() const;

 private:
  /// Arrays that build() or with_face_order() made.
  struct OwnedArrays;
  static BaseMesh of(std::shared_ptr<const OwnedArrays> made, std::uint64_t input_vertex_count);

  const MeshArrays& needed(MeshArray array) const {
    if (pages_) pages_->need(array);
    return arrays_;
  }

  MeshArrays arrays_;
  std::shared_ptr<const void> owner_, maps_owner_;  ///< of the arrays, unless there are pages
  std::shared_ptr<const MeshPages> pages_;
  std::shared_ptr<const SlotShapes> slot_shapes_;  ///< nullptr: of no edge
  std::shared_ptr<const FaceDepths> depths_;       ///< nullptr: all faces have all levels
  std::shared_ptr<const MeshRegion> region_;       ///< nullptr: the whole mesh
  std::uint64_t piece_bytes_ = 0;
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
