// A semi-regular mesh as a program without plait would keep it: one triangular array per base face,
// with the vertices on edges in the arrays of both faces. plait_bench_at_overhead compares with it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/edge_index.h"

namespace plait::bench {

/// Satisfies PatchMesh for programs whose results do not depend on the face that computes them.
/// Here every face owns all of its vertices, so both faces of an edge compute the edge's vertices,
/// each in its own array.
template <class RecordType>
class FaceArrays {
 public:
  using Record = RecordType;

  class Patch {
   public:
    Patch(FaceArrays* mesh, FaceId face)
        : mesh_(mesh), grid_(mesh->grid(face)), rows_(mesh->rows_.data()), face_(face) {
      for (int side = 0; side < 3; ++side) {
        const FaceSide there = mesh->topology_.across(FaceSide(face, side));
        if (there.exists())
          across_[static_cast<std::size_t>(side)] = {mesh->grid(there.face()), there.side()};
      }
    }
    FaceId face() const { return face_; }
    bool owns(int) const { return true; }
    bool is_border(int side) const {
      return !mesh_->topology_.across(FaceSide(face_, side)).exists();
    }
    std::int64_t size(int level) const { return std::int64_t{1} << level; }
    [[gnu::always_inline]] Record& at(int level, std::int64_t i, std::int64_t j) const {
      if ((i | j | ((std::int64_t{1} << level) - i - j)) < 0) [[unlikely]]
        return beyond(level, i, j);
      const int shift = mesh_->levels_ - level;
      return grid_[rows_[j << shift] + (i << shift)];
    }
    bool exists(int level, std::int64_t i, std::int64_t j) const {
      return unfold_fully(mesh_->topology_, {face_, level, i, j}).face != kNoId;
    }

   private:
    [[gnu::noinline]] Record& beyond(int level, std::int64_t i, std::int64_t j) const {
      const std::int64_t size = std::int64_t{1} << level, k[3] = {size - i - j, i, j};
      const int side = side_beyond({face_, level, i, j});
      const auto& [grid, turned] = across_[static_cast<std::size_t>(side)];
      std::int64_t there[3];
      there[(turned + 1) % 3] = size - k[(side + 1) % 3];
      there[(turned + 2) % 3] = size - k[(side + 2) % 3];
      there[turned] = -k[side];
      if (grid != nullptr && (there[0] | there[1] | there[2]) >= 0) {
        const int shift = mesh_->levels_ - level;
        return grid[rows_[there[2] << shift] + (there[1] << shift)];
      }
      const FaceIndex point = unfold_fully(mesh_->topology_, {face_, level, i, j});
      return Patch(mesh_, point.face).at(level, point.i, point.j);
    }
    FaceArrays* mesh_;
    Record* grid_;
    const std::int64_t* rows_;
    FaceId face_;
    struct Across {
      Record* grid = nullptr;
      int side = 0;
    };
    std::array<Across, 3> across_;
  };

  /// `base` must outlive this object.
  FaceArrays(const BaseMesh& base, int levels)
      : topology_(base.topology()), levels_(levels), base_records_(base.vertex_count()) {
    const std::int64_t size = std::int64_t{1} << levels;
    for (std::int64_t j = 0; j <= size; ++j) {
      rows_.push_back(grid_records_);
      grid_records_ += size + 1 - j;
    }
    records_.resize(base.face_count() * static_cast<std::size_t>(grid_records_));
  }

  const Topology& topology() const { return topology_; }
  std::span<Record> base_records() { return base_records_; }
  /// Copies the base vertices into the arrays of their faces.
  void activate(int, int, int) {
    const std::int64_t size = std::int64_t{1} << levels_;
    for (FaceId face = 0; face < topology_.faces.size(); ++face)
      for (int corner = 0; corner < 3; ++corner)
        grid(face)[corner == 2 ? rows_.back() : corner * size] =
            base_records_[topology_.faces[face][static_cast<std::size_t>(corner)]];
  }
  Patch patch(FaceId face) { return Patch(this, face); }

 private:
  Record* grid(FaceId face) {
    return records_.data() + face * static_cast<std::size_t>(grid_records_);
  }

  Topology topology_;
  int levels_;
  std::vector<Record> base_records_;
  std::vector<std::int64_t> rows_;  ///< [j] the index of the row's first record
  std::int64_t grid_records_ = 0;
  std::vector<Record> records_;
};

}  // namespace plait::bench
