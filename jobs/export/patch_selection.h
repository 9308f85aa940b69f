// export/patch_selection.h: the patches that an export writes, and the numbers of their vertices:
// base vertices first, then level by level in the order of slots. If all patches are selected,
// these are the numbers of VertexNumbering. They are computed, not stored, so the memory depends
// on the base mesh only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_NAMESPACE

/// Base faces in layout order, both ends included.
struct FaceRange {
  FaceId first = 0, last = 0;
};

/// Immutable. The base mesh must outlive it.
class PatchSelection {
 public:
  /// `faces` ascend. `refinements`: how often the base mesh is refined.
  PatchSelection(const BaseMesh& base, int refinements, std::vector<FaceId> faces);

  int refinements() const { return refinements_; }
  std::span<const FaceId> faces() const { return faces_; }
  std::uint64_t vertex_count() const { return first_.back(); }
  std::uint64_t triangle_count() const { return faces_.size() << (2 * refinements_); }
  /// The base vertices of the patches, ascending.
  std::span<const VertexId> base_vertices() const { return vertices_; }
  /// How much of the slot of an edge the patches have.
  SlotShape shape(EdgeId edge) const { return shapes_.shape(edge); }
  /// Whether a half slot is that of the edge's own face. REQUIRES: shape(edge) is kHalf.
  bool has_own_face(EdgeId edge) const;

  /// The number of a vertex. REQUIRES: the face is one of faces().
  std::uint64_t number(const FaceIndex& point) const;

 private:
  bool contains(FaceSide side) const { return side.exists() && selected_[side.face()]; }

  Topology mesh_;
  int refinements_;
  std::vector<FaceId> faces_;
  std::vector<bool> selected_;         ///< [face]
  std::vector<VertexId> vertices_;     ///< ascending
  std::vector<std::uint32_t> number_;  ///< [base vertex] its number, if a patch has it
  SlotShapes shapes_;
  std::vector<std::uint64_t> first_;     ///< [refinement] the number of its first vertex
  std::vector<LevelGeometry> geometry_;  ///< [refinement], records of one byte
};

/// Part number `part` of `parts`: consecutive faces, about as many in each part.
std::vector<FaceId> face_stretch(std::span<const FaceId> faces, std::uint64_t part,
                                 std::uint64_t parts);
std::vector<FaceId> all_faces(const BaseMesh& base);

PLAIT_END_NAMESPACE
