// plait/in_core_mesh.h: a semi-regular mesh in plain arrays: what a program has that does not need
// plait yet, and the floor that the transparent executor is measured against.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/edge_index.h"

namespace plait {

/// Satisfies PatchMesh. One array of n x n records per edge on every level; border edges use the
/// triangle and leave the rest.
template <class RecordType>
class InCoreMesh {
 public:
  using Record = RecordType;

  class Patch {
   public:
    FaceId face() const { return face_; }
    bool owns(int side) const { return mesh_->topology_.is_own(face_, side); }
    bool is_border(int side) const {
      return !mesh_->topology_.across(FaceSide(face_, side)).exists();
    }
    Record& at(int level, std::int64_t i, std::int64_t j) const {
      return mesh_->at({face_, level, i, j});
    }
    bool exists(int level, std::int64_t i, std::int64_t j) const {
      return unfold_fully(mesh_->topology_, {face_, level, i, j}).face != kNoId;
    }

   private:
    friend class InCoreMesh;
    Patch(InCoreMesh* mesh, FaceId face) : mesh_(mesh), face_(face) {}
    InCoreMesh* mesh_;
    FaceId face_;
  };

  /// `base` must outlive this object. Base records start as zeros.
  InCoreMesh(const BaseMesh& base, int levels)
      : topology_(base.topology()), base_records_(base.vertex_count()) {
    for (int level = 1; level <= levels; ++level)
      levels_.emplace_back(base.edge_count() * slot_records(level));
  }

  Topology topology() const { return topology_; }
  std::span<Record> base_records() { return base_records_; }
  void activate(int, int, int) {}
  Patch patch(FaceId face) { return Patch(this, face); }

 private:
  Record& at(FaceIndex point) {
    point = unfold_fully(topology_, point);
    if (is_corner(point.level, point.i, point.j))
      return base_records_[topology_.faces[point.face]
                                          [static_cast<std::size_t>(corner_of(point.i, point.j))]];
    const EdgeIndex index = edge_index(topology_, point);
    const auto n = static_cast<std::uint64_t>(slot_side(index.level));
    return levels_[static_cast<std::size_t>(index.level - 1)]
                  [index.edge * n * n + static_cast<std::uint64_t>(index.row) * n +
                   static_cast<std::uint64_t>(index.column)];
  }

  Topology topology_;
  std::vector<Record> base_records_;
  std::vector<std::vector<Record>> levels_;
};

}  // namespace plait
