// plait/extend/vertex_numbering.h: numbers all vertices of a refined mesh: base vertices first,
// then level by level in slot order. The numbers are computed, not stored. `plait export` writes
// vertices in this order.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// Level 0 is `mesh`, as in every call that takes a mesh and no store. Immutable. The arrays that
/// `mesh` refers to must outlive this object.
class VertexNumbering {
 public:
  VertexNumbering(const Topology& mesh, int levels) : mesh_(mesh) {
    first_.push_back(0);
    first_.push_back(mesh.vertex_corners.size());
    geometry_.emplace_back();
    const SlotShapes shapes(mesh);
    for (int level = 1; level <= levels; ++level) {
      geometry_.emplace_back(shapes, BaseRelativeLevel(level), 1, 1);
      first_.push_back(first_.back() + geometry_.back().total_bytes());
    }
  }

  std::uint64_t vertex_count() const { return first_.back(); }
  /// Number of the first vertex that `level` creates.
  std::uint64_t first_of(int level) const { return first_[static_cast<std::size_t>(level)]; }

  std::uint64_t number(const FaceIndex& point) const {
    if (is_corner(point.level, point.i, point.j))
      return mesh_.faces[point.face][static_cast<std::size_t>(corner_of(point.i, point.j))];
    const EdgeIndex at = edge_index(mesh_, point);
    const auto level = static_cast<std::size_t>(at.level);
    const Slot slot = geometry_[level].slot(at.edge);
    return first_[level] + slot.offset +
           static_cast<std::uint64_t>(slot_position(at.level, slot.shape, at.row, at.column));
  }

 private:
  Topology mesh_;
  std::vector<std::uint64_t> first_;     ///< [level]
  std::vector<LevelGeometry> geometry_;  ///< [level], records of one byte
};

/// A point of the grid of a face.
struct FacePoint {
  std::int64_t i, j;
};

/// Calls visit(std::array<FacePoint, 3>) for the 4^level triangles of a face, counterclockwise.
template <class Visit>
void for_each_triangle(int level, Visit visit) {
  const std::int64_t size = std::int64_t{1} << level;
  for (std::int64_t j = 0; j < size; ++j)
    for (std::int64_t i = 0; i + j < size; ++i) {
      visit(std::array<FacePoint, 3>{{{i, j}, {i + 1, j}, {i, j + 1}}});
      if (i + j + 1 < size)
        visit(std::array<FacePoint, 3>{{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}});
    }
}

PLAIT_END_NAMESPACE
