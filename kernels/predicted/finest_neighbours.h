// Finds vertices of the finest level in the slots around an edge, by their places in the edge's
// grid (plait/detail/edge_grid.h), without gathering the grid: a coarser vertex has six
// neighbours, and the grid has many more points. Pinned by tests/kernels/made_normals_test.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plait/detail/slot_shapes.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The points of a run: (p, q), (p, q + step), and so on.
struct GridRun {
  std::int64_t p, q;
  std::int64_t step;  ///< even
  std::int64_t count;
};

/// All points are (p, q) of the grid.
template <class Record>
class FinestNeighbours {
 public:
  /// `slots` has the function slot(level, edge) of SourceSlots.
  template <class Slots>
  FinestNeighbours(const Topology& mesh, const Slots& slots, EdgeId edge, int finest)
      : level_(finest), n_(slot_side(finest)), own_(side_of(slots.slot(finest, edge), true)) {
    for (const bool turned : {false, true}) {
      const FaceSide face = turned ? mesh.edges[edge].other : mesh.edges[edge].own;
      if (!face.exists()) continue;
      for (int turn = 1; turn < 3; ++turn) {
        const FaceSide side(face.face(), (face.side() + turn) % 3);
        const EdgeId other = mesh.face_edges[side.face()][static_cast<std::size_t>(side.side())];
        sides_[turned ? 1 : 0][static_cast<std::size_t>(turn - 1)] =
            side_of(slots.slot(finest, other), mesh.edges[other].own == side);
      }
    }
    const auto is_half = [](const Side& side) { return side.shape == SlotShape::kHalf; };
    meets_half_slot_ = is_half(own_) || std::ranges::any_of(sides_[0], is_half) ||
                       std::ranges::any_of(sides_[1], is_half);
  }

  /// Both odd: the slot of the edge itself.
  const Record* along(std::int64_t p, std::int64_t q) const {
    return at(own_, (p - 1) / 2, (q - 1) / 2);
  }
  /// p even, q odd: the slot of the next side of the face.
  const Record* across_p(std::int64_t p, std::int64_t q) const {
    const bool turned = turn(p, q);
    return at(sides_[turned ? 1 : 0][0], (q - 1) / 2, (2 * n_ - 1 - p - q) / 2);
  }
  /// p odd, q even: the slot of the last side.
  const Record* across_q(std::int64_t p, std::int64_t q) const {
    const bool turned = turn(p, q);
    return at(sides_[turned ? 1 : 0][1], (2 * n_ - 1 - p - q) / 2, (p - 1) / 2);
  }

  /// Copies the records of a run. All of them exist.
  void copy_along(const GridRun& run, Record* to) const {
    const auto find = [&](std::int64_t q) { return along(run.p, q); };
    if (meets_half_slot_)
      copy_each(find, run, to);
    else
      copy_run(find(run.q), run.step / 2, run.count, to);
  }
  void copy_across_p(const GridRun& run, Record* to) const {
    copy_across(
        0, n_ - 1, [&](std::int64_t q) { return across_p(run.p, q); }, run, to);
  }
  void copy_across_q(const GridRun& run, Record* to) const {
    copy_across(
        1, -n_, [&](std::int64_t q) { return across_q(run.p, q); }, run, to);
  }

 private:
  struct Side {
    const Record* slot = nullptr;
    bool is_own = true;  ///< the slot has the rows and columns of this face
    SlotShape shape = SlotShape::kWhole;
  };

  static Side side_of(const SlotRecords<const Record>& slot, bool is_own) {
    return {slot.data(), is_own, slot.shape};
  }

  static void copy_run(const Record* from, std::ptrdiff_t distance, std::int64_t count,
                       Record* to) {
    for (std::int64_t i = 0; i < count; ++i, from += distance) to[i] = *from;
  }
  template <class Find>
  static void copy_each(Find find, const GridRun& run, Record* to) {
    for (std::int64_t i = 0; i < run.count; ++i) to[i] = *find(run.q + i * run.step);
  }
  /// `distance` is that of the records of (p, q) and (p, q + 2) in a whole slot of the own face.
  /// In half slots, the distance depends on the row.
  template <class Find>
  void copy_across(std::size_t side, std::ptrdiff_t distance, Find find, const GridRun& run,
                   Record* to) const {
    if (meets_half_slot_) return copy_each(find, run, to);
    // No point across is on the edge, where p + q = 2 n.
    const std::int64_t to_edge = (2 * n_ - run.p - run.q + run.step - 1) / run.step;
    const std::int64_t in_own = std::clamp<std::int64_t>(to_edge, 0, run.count);
    const std::ptrdiff_t step = run.step / 2 * distance;
    if (in_own > 0) copy_run(find(run.q), sides_[0][side].is_own ? step : -step, in_own, to);
    if (in_own < run.count)
      copy_run(find(run.q + in_own * run.step), sides_[1][side].is_own ? -step : step,
               run.count - in_own, to + in_own);
  }

  /// In the other face, the weights of the edge's ends are those of the own face turned.
  bool turn(std::int64_t& p, std::int64_t& q) const {
    const bool turned = p + q > 2 * n_;
    if (turned) {
      p = 2 * n_ - p;
      q = 2 * n_ - q;
    }
    return turned;
  }
  const Record* at(const Side& side, std::int64_t row, std::int64_t column) const {
    if (side.shape == SlotShape::kHalf)
      return side.slot + slot_position(level_, side.shape, row, column);
    const std::int64_t place = row * n_ + column;
    return side.slot + (side.is_own ? place : n_ * n_ - 1 - place);
  }

  int level_;
  std::int64_t n_;
  Side own_;
  std::array<std::array<Side, 2>, 2> sides_ = {};  ///< [other face][turn - 1]
  bool meets_half_slot_ = false;
};

PLAIT_END_NAMESPACE
