// generate/surface_editor.h: a triangulated surface whose edges can be collapsed one by one.
//
// A side is 3 * face + x, the side opposite corner x; it runs from corner x+1 to corner x+2. For
// every side the object stores the other side of the same edge (kNoId on a border), and for every
// vertex one of its corners. Invariant: an oriented 2-manifold, with or without border, in which
// two faces share at most one edge and no two edges the same end points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

class SurfaceEditor {
 public:
  using Side = std::uint32_t;

  /// REQUIRES: `mesh` satisfies the invariant, and every vertex is used.
  explicit SurfaceEditor(IndexedMesh mesh);

  std::uint64_t live_vertex_count() const { return live_vertex_count_; }
  /// One past the largest side number. Sides of removed faces count.
  Side side_limit() const { return static_cast<Side>(3 * faces_.size()); }
  bool is_live(Side side) const { return faces_[side / 3][0] != kNoId; }
  bool is_border(Side side) const { return beyond_[side] == kNoId; }
  Side beyond(Side side) const { return beyond_[side]; }

  VertexId apex(Side side) const { return faces_[side / 3][side % 3]; }
  VertexId start(Side side) const { return apex(next(side)); }
  VertexId end(Side side) const { return apex(previous(side)); }
  const Vector3<double>& position(VertexId vertex) const { return positions_[vertex]; }

  static Side next(Side side) { return side % 3 == 2 ? side - 2 : side + 1; }
  static Side previous(Side side) { return side % 3 == 0 ? side + 2 : side - 1; }

  /// Calls visit(side) for the side opposite `vertex` in each of its faces.
  template <class Visit>
  void for_each_link_side(VertexId vertex, Visit visit) const;
  bool is_on_border(VertexId vertex) const;
  int valence(VertexId vertex) const;

  /// Whether the edge can be collapsed without changing the surface's topology (link condition).
  /// Source: T. Dey, H. Edelsbrunner, S. Guha, D. Nekhayev, "Topology preserving edge contraction"
  /// (1999).
  bool can_collapse(Side side) const;
  /// Merges the edge's end into its start, which moves to `position`.
  /// REQUIRES: can_collapse(side).
  void collapse(Side side, Vector3<double> position);

  /// The remaining mesh, with new numbers in the same order.
  IndexedMesh take() &&;

 private:
  void join(Side first, Side second);
  int count_common_neighbours(VertexId a, VertexId b) const;

  std::vector<Vector3<double>> positions_;
  std::vector<std::array<VertexId, 3>> faces_;
  std::vector<Side> beyond_;
  std::vector<Side> corner_of_vertex_;  ///< a corner is given by the side opposite it
  std::uint64_t live_vertex_count_;
  mutable std::vector<std::uint32_t> mark_of_vertex_;  ///< for count_common_neighbours
  mutable std::uint32_t mark_ = 0;
};

template <class Visit>
void SurfaceEditor::for_each_link_side(VertexId vertex, Visit visit) const {
  const Side first = corner_of_vertex_[vertex];
  Side side = first;
  do {
    visit(side);
    const Side crossed = beyond_[next(side)];
    if (crossed == kNoId) {
      // At a border, visit the faces on the other side of the first one.
      for (Side back = beyond_[previous(first)]; back != kNoId; back = beyond_[back]) {
        back = previous(back);
        visit(back);
        back = previous(back);
      }
      return;
    }
    side = next(crossed);
  } while (side != first);
}

}  // namespace generation
PLAIT_END_NAMESPACE
