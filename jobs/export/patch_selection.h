// export/patch_selection.h: the patches that an export writes, and the numbers of their vertices:
// base vertices first, then level by level in the order of slots. If all patches are selected,
// these are the numbers of VertexNumbering. They are computed, not stored, so the memory depends
// on the base mesh only.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/drawn_triangles.h"
#include "plait/detail/face_depths.h"
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
  /// `faces` ascend. `refinements`: how often the base mesh is refined, at most; a face of a base
  /// mesh with depths only as often as its depth says.
  PatchSelection(const BaseMesh& base, int refinements, std::vector<FaceId> faces)
      : PatchSelection(base, refinements, std::move(faces), nullptr) {}
  /// Some of the patches, ascending `faces`, drawn as they are among all of them. Where a face of
  /// another part is deeper, this part has its half slots of the side too, of which triangles use
  /// only the vertices on the side.
  PatchSelection part(std::vector<FaceId> faces) const;

  int refinements() const { return refinements_; }
  std::span<const FaceId> faces() const { return faces_; }
  std::uint64_t vertex_count() const { return first_.back(); }
  std::uint64_t triangle_count() const { return triangle_count_; }
  /// How the face is drawn: a deeper neighbour among the patches has vertices on its sides.
  DrawnDepths drawn(FaceId face) const;
  /// The base vertices of the patches, ascending.
  std::span<const VertexId> base_vertices() const { return vertices_; }
  /// How much of the slot of an edge the patches have at a level.
  SlotShape shape(EdgeId edge, BaseRelativeLevel level) const {
    return shapes_at(level.refinements).shape(edge);
  }
  /// Whether a half slot is that of the edge's own face. REQUIRES: shape(edge, level) is kHalf.
  bool has_own_face(EdgeId edge, BaseRelativeLevel level) const;

  /// The number of a vertex. REQUIRES: the face is one of faces(); it or, for a point on a side,
  /// the face across has the vertex.
  std::uint64_t number(const FaceIndex& point) const;

 private:
  PatchSelection(const BaseMesh& base, int refinements, std::vector<FaceId> faces,
                 const PatchSelection* whole);

  bool contains(FaceSide side) const { return side.exists() && selected_[side.face()]; }
  /// Whether the face is in another part of the same selection.
  bool is_in_other_part(FaceSide side) const {
    return side.exists() && !others_.empty() && others_[side.face()];
  }
  int depth(FaceId face) const {
    return depths_ == nullptr ? refinements_ : std::min(refinements_, depths_->of(face));
  }
  /// Whether the patches have the half of a slot that is in the face of `side`, and `beyond` is the
  /// other face of the edge.
  bool has(FaceSide side, FaceSide beyond, int level) const {
    if (!side.exists() || depth(side.face()) < level) return false;
    return contains(side) ||
           (is_in_other_part(side) && contains(beyond) && depth(beyond.face()) < level);
  }
  SlotShapes make_shapes(int level) const;
  const SlotShapes& shapes_at(int level) const {
    return shapes_[depths_ == nullptr ? 0 : static_cast<std::size_t>(level - 1)];
  }

  const BaseMesh* base_;
  Topology mesh_;
  const FaceDepths* depths_;
  int refinements_;
  std::uint64_t triangle_count_ = 0;
  std::vector<FaceId> faces_;
  std::vector<bool> selected_;           ///< [face]
  std::vector<bool> others_;             ///< [face] in other parts; empty if there are none
  std::vector<VertexId> vertices_;       ///< ascending
  std::vector<std::uint32_t> number_;    ///< [base vertex] its number, if a patch has it
  std::vector<SlotShapes> shapes_;       ///< [level - 1] with depths; else one for all levels
  std::vector<std::uint64_t> first_;     ///< [refinement] the number of its first vertex
  std::vector<LevelGeometry> geometry_;  ///< [refinement], records of one byte
};

/// Part number `part` of `parts`: consecutive faces, about as many in each part.
std::vector<FaceId> face_stretch(std::span<const FaceId> faces, std::uint64_t part,
                                 std::uint64_t parts);
std::vector<FaceId> all_faces(const BaseMesh& base);

PLAIT_END_NAMESPACE
