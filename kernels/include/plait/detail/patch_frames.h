// plait/detail/patch_frames.h: visits the vertices that a patch computes, and finds their
// neighbours by direction.
#pragma once

#include <cstdint>
#include <type_traits>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// A side of a face as a type. So a function that is compiled for each side has the directions as
/// constants.
template <int kSide>
using PatchSide = std::integral_constant<int, kSide>;

/// Calls visit(PatchSide, row, column, on_border) for each vertex of `level` that the current patch
/// computes: the vertices inside the patch, and those on the edges that the patch owns. Row and
/// column are in the slot of that side, as seen from this face. PatchFrame converts them to a place
/// in the patch.
template <class Patch, class Visit>
void for_each_owned(const Patch& patch, int level, Visit visit) {
  const std::int64_t n = patch.size(level) / 2;
  const auto visit_side = [&](auto side) {
    const bool owns = patch.owns(side), border = patch.is_border(side);
    for (std::int64_t row = 0; row < n; ++row) {
      for (std::int64_t column = 0; column < n - 1 - row; ++column) visit(side, row, column, false);
      if (owns) visit(side, row, n - 1 - row, border);
    }
  };
  visit_side(PatchSide<0>());
  visit_side(PatchSide<1>());
  visit_side(PatchSide<2>());
}

/// A vertex of a patch and its neighbours, in the frame of a side of the face: in steps towards the
/// side's start and end. In the other face of an edge this frame is rotated by 180 degrees, which
/// does not change the result of a rule.
template <int kSide, class Patch>
class PatchFrame {
 public:
  /// The vertex at (row, column) of the side's slot at `level`. Steps are those of the grid of
  /// `grid_level`.
  PatchFrame(const Patch& patch, PatchSide<kSide>, int level, std::int64_t row, std::int64_t column,
             int grid_level)
      : patch_(patch), level_(grid_level) {
    const std::int64_t at_start = 2 * row + 1, at_end = 2 * column + 1;
    const std::int64_t opposite = patch.size(level) - at_start - at_end;
    const auto weight = [&](int corner) {
      return corner == kSide ? opposite : corner == (kSide + 1) % 3 ? at_start : at_end;
    };
    i_ = weight(1) << (grid_level - level);
    j_ = weight(2) << (grid_level - level);
  }

  /// The vertex `p` steps towards the start and `q` towards the end.
  [[gnu::always_inline]] auto& at(std::int64_t p, std::int64_t q) const {
    return patch_.at(level_, i_ + step(1, p, q), j_ + step(2, p, q));
  }
  /// The same vertex, read at the next coarser level. REQUIRES: it exists at that level.
  [[gnu::always_inline]] auto& coarse_at(std::int64_t p, std::int64_t q) const {
    return patch_.at(level_ - 1, (i_ + step(1, p, q)) >> 1, (j_ + step(2, p, q)) >> 1);
  }
  bool exists(std::int64_t p, std::int64_t q) const {
    return patch_.exists(level_, i_ + step(1, p, q), j_ + step(2, p, q));
  }

 private:
  /// The change of the weight of a corner.
  static constexpr std::int64_t step(int corner, std::int64_t p, std::int64_t q) {
    return corner == kSide ? -(p + q) : corner == (kSide + 1) % 3 ? p : q;
  }

  const Patch patch_;
  int level_;
  std::int64_t i_, j_;
};

PLAIT_END_NAMESPACE
