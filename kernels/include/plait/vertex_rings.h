// plait/vertex_rings.h: what a kernel of visit_vertices() gets for the vertices that it computes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// A point of the triangular grid of a base face. The corners are (0, 0), (size, 0) and (0, size),
/// in the order of BaseMesh::faces(). So the barycentric coordinates of the point are
/// (size - i - j, i, j) / size: where to sample a height map or a texture of the face.
struct PatchPoint {
  FaceId face = 0;
  std::int64_t i = 0, j = 0, size = 1;
  friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// The vertices of one kernel call. They are consecutive in their level.
struct VertexRun {
  /// The level that creates them. For base vertices, Store::base_level().
  int level = 0;
  /// The number of the first one among the vertices that `level` creates, in the order of
  /// VertexNumbering (plait/extend/vertex_numbering.h) and of Reader::for_each_block. Of base
  /// vertices it is the VertexId.
  std::uint64_t first = 0;
  std::size_t count = 0;
  EdgeId edge = kNoId;  ///< the base edge that owns them; kNoId for base vertices
  int worker = 0;       ///< of the calling thread: 0 to threads - 1

  bool is_base() const noexcept { return edge == kNoId; }
  /// Where vertex `i` of the run is, at the run's level. A vertex on an edge is in two faces: this
  /// is a point of the edge's own face (plait/extend/topology.h). A base vertex is a corner of many
  /// faces: this is a point of the face of Topology::vertex_corners. Valid during the kernel call.
  /// REQUIRES: i < count.
  PatchPoint point(std::size_t i) const noexcept {
    if (is_base()) {
      const FaceSide corner = mesh_->vertex_corners[static_cast<std::size_t>(first) + i];
      const FaceIndex at = corner_point(corner.face(), 0, corner.side());
      return {at.face, at.i, at.j, 1};
    }
    SlotPoint in_slot =
        slot_point(refinement_, shape_, static_cast<std::int64_t>(first - first_of_slot_ + i));
    if (is_of_other_face_) [[unlikely]] {
      const std::int64_t last = slot_side(refinement_) - 1;
      in_slot = {last - in_slot.row, last - in_slot.column};
    }
    const FaceIndex at = face_index(*mesh_, {edge, refinement_, in_slot.row, in_slot.column});
    return {at.face, at.i, at.j, std::int64_t{1} << refinement_};
  }

 private:
  friend class VisitPlan;
  const Topology* mesh_ = nullptr;
  int refinement_ = 0;
  std::uint64_t first_of_slot_ = 0;
  SlotShape shape_ = SlotShape::kWhole;
  bool is_of_other_face_ = false;  ///< a half slot in the frame of the face across the edge
};

/// The vertices of a run and their neighbours, all at the finest level of the visit. In a store
/// whose faces have depths of their own, the neighbours of a vertex are at the finest level that
/// all faces around the vertex have. A vertex on an edge that only one of the two faces has is, for
/// that face, on a border. All vertices of the run have equally many neighbours, and are either all
/// on a border or all inside. Valid during the kernel call.
template <class Record>
class VertexRings {
 public:
  VertexRings(const Record* first, std::ptrdiff_t step, const std::ptrdiff_t* to_neighbours,
              int valence, bool border) noexcept
      : first_(first),
        step_(step),
        to_neighbours_(to_neighbours),
        valence_(valence),
        border_(border) {}

  /// The number of neighbours: 6, or 4 on a border, except for base vertices, which may have any.
  int valence() const noexcept { return valence_; }
  bool is_border() const noexcept { return border_; }

  /// Vertex `i` of the run. REQUIRES: i < VertexRun::count.
  const Record& vertex(std::size_t i) const noexcept {
    return first_[static_cast<std::ptrdiff_t>(i) * step_];
  }
  /// Neighbour `k` of vertex `i`. Neighbours are in counterclockwise order. On a border the first
  /// and the last one are on the border, too. Inside, the base mesh alone decides which one is the
  /// first, so a sum has the same bits on every backend and in every layout. REQUIRES: 0 <= k <
  /// valence().
  const Record& neighbour(std::size_t i, int k) const noexcept {
    return first_[static_cast<std::ptrdiff_t>(i) * step_ + to_neighbours_[k]];
  }

 private:
  const Record* first_;
  std::ptrdiff_t step_;                  ///< from one vertex to the next
  const std::ptrdiff_t* to_neighbours_;  ///< [k] from a vertex to its neighbour k
  int valence_;
  bool border_;
};

PLAIT_END_NAMESPACE
