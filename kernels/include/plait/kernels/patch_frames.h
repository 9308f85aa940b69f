// plait/kernels/patch_frames.h: which vertices a patch computes, and their neighbours by direction.
#pragma once

#include <cstdint>

#include "plait/edge_index.h"

namespace plait {

/// The vertices that the current patch computes at one level of birth: those in its interior and
/// those on the edges that it owns. Calls visit(side, row, column, on_border); the vertex is at
/// from_side(face, {side, level, row, column}).
template <class Patch, class Visit>
void for_each_owned(const Patch& patch, int level, Visit visit) {
  const std::int64_t n = slot_side(level);
  for (int side = 0; side < 3; ++side) {
    const bool owns = patch.owns(side), border = patch.is_border(side);
    for (std::int64_t row = 0; row < n; ++row)
      for (std::int64_t column = 0; column < n - row; ++column) {
        const bool on_edge = row + column == n - 1;
        if (!on_edge || owns) visit(side, row, column, on_edge && border);
      }
  }
}

/// A vertex of a patch and its surroundings as seen from a side of the face, in steps towards the
/// side's start and end. Seen from the other face of an edge everything is turned by half, which
/// the rules do not notice.
template <class Patch>
class PatchFrame {
 public:
  /// `grid_level` is the level whose grid the steps are in.
  PatchFrame(const Patch& patch, SideIndex index, int grid_level)
      : patch_(patch),
        side_(index.side),
        place_(at_level(from_side(patch.face(), index), grid_level)) {}

  /// The vertex `p` steps towards the start and `q` towards the end.
  auto& at(std::int64_t p, std::int64_t q) const {
    const FaceIndex point = step(p, q);
    return patch_.at(point.level, point.i, point.j);
  }
  /// The same of a vertex that the next coarser level has. REQUIRES: it has.
  auto& coarse_at(std::int64_t p, std::int64_t q) const {
    const FaceIndex point = step(p, q);
    return patch_.at(point.level - 1, point.i >> 1, point.j >> 1);
  }
  bool exists(std::int64_t p, std::int64_t q) const {
    const FaceIndex point = step(p, q);
    return patch_.exists(point.level, point.i, point.j);
  }

 private:
  FaceIndex step(std::int64_t p, std::int64_t q) const {
    std::int64_t weight[3];
    weight[(side_ + 1) % 3] = p;
    weight[(side_ + 2) % 3] = q;
    weight[side_] = -(p + q);
    return {place_.face, place_.level, place_.i + weight[1], place_.j + weight[2]};
  }

  const Patch& patch_;
  int side_;
  FaceIndex place_;
};

}  // namespace plait
