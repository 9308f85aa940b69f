// backends/compressed/filters/edge_lattice.h: the coarser vertices around the slot of an edge, as a
// regular grid, and the predictions of the slot's vertices from them.
//
//        end (0,N)------(N,N) apex of the other face
//           | \   other   |            points (p, q), 0 <= p, q <= N = 2^(level-1)
//           |   \         |            p and q are the weights of the edge's start and end,
//           |     \       |            in the other face N minus these
//           |  own  \     |            the edge is the diagonal p + q = N
//   apex (0,0)------(N,0) start        one more row of points lies around
//
// The vertex (row, column) of the slot lies between the points A = (row, column + 1) and B = (row +
// 1, column). It is predicted by one of two rules:
//
//   midpoint    (A + B) / 2
//   butterfly   (A + B) / 2 + (C + D) / 8 - (the four wings) / 16,  with C and D opposite,
//               N. Dyn, D. Levin, J. Gregory, "A Butterfly Subdivision Scheme for Surface
//               Interpolation with Tension Control", 1990, tension 1/16; on a border edge the
//               four-point rule of the same authors, 1987
//
// in the order of operations that butterfly_row() has. Irregular vertices get no rule of their own:
// a prediction need not be smooth.
//
// A point that is not known is replaced: a vertex in the slot of an edge that is in no chosen block
// by the midpoint of its coarser neighbours; a wing beyond a border, or in such a slot, by the
// continuation of the triangle inside.
// Pinned by tests/backends/compressed/filters/hierarchy_filter_test.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "compressed/filters/coarser_blocks.h"
#include "plait/edge_index.h"
#include "plait/namespace.h"
#include "plait/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class PredictionRule : std::uint8_t { kMidpoint, kButterfly };

/// Predicts the vertices between equally spaced rows of numbers. `count` numbers each. Always
/// inlined, so that each instruction set gets a loop of its own.
template <class Number>
[[gnu::always_inline]] inline void midpoint_row(const Number* a, const Number* b,
                                                std::int64_t count, Number* to) {
  for (std::int64_t i = 0; i < count; ++i) to[i] = Number(0.5) * (a[i] + b[i]);
}
template <class Number>
struct ButterflyRow {
  const Number *a, *b, *c, *d, *wing_ac, *wing_db, *wing_cb, *wing_ad;
};
template <class Number>
[[gnu::always_inline]] inline void butterfly_row(const ButterflyRow<Number>& from,
                                                 std::int64_t count, Number* __restrict to) {
  for (std::int64_t i = 0; i < count; ++i)
    to[i] = (Number(0.5) * (from.a[i] + from.b[i]) + Number(0.125) * (from.c[i] + from.d[i])) -
            Number(0.0625) *
                ((from.wing_ac[i] + from.wing_db[i]) + (from.wing_cb[i] + from.wing_ad[i]));
}

/// For one thread; used for one edge after another.
template <class Number, std::size_t kComponents>
class EdgeLattice {
 public:
  using Record = std::array<Number, kComponents>;

  /// The memory of a lattice for slots of `refinement`.
  static constexpr std::size_t bytes(int refinement) {
    const auto stride = static_cast<std::size_t>(slot_side(refinement) + 3);
    return sizeof(Record) * (stride * stride + stride);
  }

  /// For slots of `refinement`, from the levels before it. `memory` has bytes(refinement) bytes.
  /// `base` are the records of the base vertices.
  EdgeLattice(const CoarserBlocks& levels, int refinement, std::span<const std::byte> base,
              PredictionRule rule, std::span<std::byte> memory)
      : mesh_(levels.mesh()),
        base_(reinterpret_cast<const Record*>(base.data())),
        rule_(rule),
        refinement_(refinement),
        size_(slot_side(refinement_)),
        stride_(size_ + 3),
        points_(reinterpret_cast<Record*>(memory.data())) {}

  /// Calls visit(prediction, first, count) for each row of the edge's slot: `count` numbers, from
  /// the number `first` of the slot on.
  template <class Visit>
  void predict(const CoarserSlots& slots, EdgeId edge, Visit visit) {
    gather(slots, edge);
    const bool border = mesh_.edges[edge].is_border();
    Number* const row_of_predictions = reinterpret_cast<Number*>(points_ + stride_ * stride_);
    std::int64_t first = 0;
    for (std::int64_t row = 0; row < size_; ++row) {
      const std::int64_t records = border ? size_ - row : size_;
      predict_row(row, records, border, row_of_predictions);
      const auto count = records * static_cast<std::int64_t>(kComponents);
      visit(row_of_predictions, first, count);
      first += count;
    }
  }

  /// Fills the points around the edge; with the rule midpoint, without the row around them.
  void gather(const CoarserSlots& slots, EdgeId edge) {
    gather_points(slots, edge);
    if (rule_ == PredictionRule::kMidpoint) return;
    for (const bool turned : {false, true}) {
      const FaceSide side = turned ? mesh_.edges[edge].other : mesh_.edges[edge].own;
      if (!side.exists()) continue;
      for (const bool beyond_start : {true, false}) gather_wings(slots, side, turned, beyond_start);
    }
  }
  const Record* point(std::int64_t p, std::int64_t q) const {
    return points_ + (p + 1) * stride_ + (q + 1);
  }
  std::int64_t stride() const { return stride_; }  ///< from (p, q) to (p + 1, q)

 private:
  Record* at(std::int64_t p, std::int64_t q) { return points_ + (p + 1) * stride_ + (q + 1); }
  const Number* numbers(std::int64_t p, std::int64_t q) { return at(p, q)->data(); }

  void predict_row(std::int64_t row, std::int64_t records, bool border, Number* to) {
    const Number *const a = numbers(row, 1), *const b = numbers(row + 1, 0);
    const std::int64_t inside = border ? records - 1 : records;
    constexpr auto kWidth = static_cast<std::int64_t>(kComponents);
    if (rule_ == PredictionRule::kMidpoint) return midpoint_row(a, b, records * kWidth, to);
    butterfly_row<Number>({a, b, numbers(row, 0), numbers(row + 1, 1), numbers(row - 1, 1),
                           numbers(row + 2, 0), numbers(row + 1, -1), numbers(row, 2)},
                          inside * kWidth, to);
    if (!border) return;
    // On the border itself, which is the end of the row. A is (row, N - row).
    const Number *const start = a + inside * kWidth, *const end = b + inside * kWidth;
    const bool has_before = row > 0, has_after = row + 1 < size_;
    for (std::size_t k = 0; k < kComponents; ++k) {
      const Number middle = start[k] + end[k];
      to[inside * kWidth + static_cast<std::int64_t>(k)] =
          has_before && has_after
              ? Number(0.5625) * middle - Number(0.0625) * (numbers(row - 1, inside + 2)[k] +
                                                            numbers(row + 2, inside - 1)[k])
              : Number(0.5) * middle;
    }
  }

  void gather_points(const CoarserSlots& slots, EdgeId edge) {
    for (const bool turned : {false, true}) {
      const FaceSide side = turned ? mesh_.edges[edge].other : mesh_.edges[edge].own;
      if (!side.exists()) continue;
      const auto& corners = mesh_.faces[side.face()];
      const auto corner = [&](int turn) {
        return base_[corners[static_cast<std::size_t>((side.side() + turn) % 3)]];
      };
      *at(turned ? size_ : 0, turned ? size_ : 0) = corner(0);
      *at(turned ? 0 : size_, turned ? size_ : 0) = corner(1);
      *at(turned ? size_ : 0, turned ? 0 : size_) = corner(2);
    }
    for (int refinement = 1; refinement < refinement_; ++refinement)
      for (const bool turned : {false, true}) {
        const FaceSide side = turned ? mesh_.edges[edge].other : mesh_.edges[edge].own;
        if (!side.exists()) continue;
        for (int turn = 0; turn < 3; ++turn) gather_slot(slots, side, turned, turn, refinement);
      }
  }

  /// Copies the vertices of one face that are in the slot of the face's side (side + turn).
  void gather_slot(const CoarserSlots& slots, FaceSide side, bool turned, int turn,
                   int refinement) {
    const int slots_of = (side.side() + turn) % 3;
    const EdgeId edge_id = mesh_.face_edges[side.face()][static_cast<std::size_t>(slots_of)];
    const Edge& edge = mesh_.edges[edge_id];
    const std::int64_t n = slot_side(refinement);
    const std::int64_t scale = std::int64_t{1} << (refinement_ - 1 - refinement), both = 2 * scale;
    // The place of (row 0, column 0), the steps for one more row and column, and the step to the
    // coarser neighbours of a vertex. On the side of the lattice's edge, p increases with the row
    // and q with the column; on the next side q increases with the row, and on the last side p with
    // the column; the third weight, opposite the edge, changes accordingly.
    std::int64_t first = scale * stride_ + scale, row_step = both * stride_, column_step = both;
    std::int64_t to_neighbour = scale * stride_ - scale;
    if (turn == 1) {
      first = (size_ - both) * stride_ + scale;
      row_step = both - both * stride_;
      column_step = -both * stride_;
      to_neighbour = scale;
    } else if (turn == 2) {
      first = scale * stride_ + (size_ - both);
      row_step = -both;
      column_step = both * stride_ - both;
      to_neighbour = scale * stride_;
    }
    Record* to = at(0, 0) + first;
    if (turned) {
      to = at(size_, size_) - first;
      row_step = -row_step;
      column_step = -column_step;
    }
    const std::byte* const bytes = slots.slot(refinement, edge_id);
    if (bytes == nullptr) {
      for (std::int64_t row = 0; row < n; ++row, to += row_step)
        for (std::int64_t column = 0; column < n - row; ++column) {
          Record* const vertex = to + column * column_step;
          for (std::size_t k = 0; k < kComponents; ++k)
            (*vertex)[k] = Number(0.5) * (vertex[to_neighbour][k] + vertex[-to_neighbour][k]);
        }
      return;
    }
    const Record* from = reinterpret_cast<const Record*>(bytes);
    const bool own = edge.own == FaceSide(side.face(), slots_of);
    const bool triangle = edge.is_border();
    const std::int64_t step = own ? 1 : -1;
    if (!own) from += n * n - 1;
    for (std::int64_t row = 0; row < n; ++row) {
      for (std::int64_t column = 0; column < n - row; ++column)
        to[column * column_step] = from[column * step];
      to += row_step;
      from += triangle ? n - row : n * step;
    }
  }

  /// Fills the points (-1, k) or (k, -1), 1 <= k <= N, beyond a face, in the face's own frame. They
  /// are the points with weight 1 of the next face's apex, and have the weights k - 1 and N - k of
  /// the ends of the edge between. Of this edge, k counts from the apex of the lattice on.
  void gather_wings(const CoarserSlots& slots, FaceSide side, bool turned, bool beyond_start) {
    const auto place = [&](std::int64_t p, std::int64_t q) -> Record& {
      return turned ? *at(size_ - p, size_ - q) : *at(p, q);
    };
    const auto wing = [&](std::int64_t k) -> Record& {
      return beyond_start ? place(-1, k) : place(k, -1);
    };
    const auto continue_at = [&](std::int64_t k) {
      const Record& end0 = beyond_start ? place(0, k) : place(k, 0);
      const Record& end1 = beyond_start ? place(0, k - 1) : place(k - 1, 0);
      const Record& inside = beyond_start ? place(1, k - 1) : place(k - 1, 1);
      for (std::size_t c = 0; c < kComponents; ++c) wing(k)[c] = (end0[c] + end1[c]) - inside[c];
    };
    // The side opposite the start is the one after the edge's side.
    const FaceSide beyond =
        mesh_.across(FaceSide(side.face(), (side.side() + (beyond_start ? 1 : 2)) % 3));
    if (!beyond.exists()) {
      for (std::int64_t k = 1; k <= size_; ++k) continue_at(k);
      return;
    }
    if (refinement_ == 1) {
      wing(1) = base_[mesh_.faces[beyond.face()][static_cast<std::size_t>(beyond.side())]];
      return;
    }
    // Corners of the next face, counted from its apex on. It sees the edge between in the other
    // direction: the corner after its apex is the apex of the lattice if the edge between is
    // opposite the start.
    const int far_corner = beyond_start ? 2 : 1;
    const int refinement = refinement_ - 1;
    const std::int64_t n = slot_side(refinement);
    for (const std::int64_t first : {1, 2}) {
      // Two weights are odd: 1 of the next face's apex, and one of the others. The vertex is in the
      // slot of the side between these two corners.
      const bool far_is_odd = first == 2;
      const int odd_corner = far_is_odd ? far_corner : 3 - far_corner;
      const int slots_of = (beyond.side() + 3 - odd_corner) % 3;
      const EdgeId edge_id = mesh_.face_edges[beyond.face()][static_cast<std::size_t>(slots_of)];
      const Edge& edge = mesh_.edges[edge_id];
      const std::byte* const bytes = slots.slot(refinement, edge_id);
      const Record* const from = reinterpret_cast<const Record*>(bytes);
      const bool own = edge.own == FaceSide(beyond.face(), slots_of), half = edge.is_border();
      for (std::int64_t k = first; k <= size_; k += 2) {
        if (bytes == nullptr) {
          continue_at(k);
          continue;
        }
        const std::int64_t odd = ((far_is_odd ? k - 1 : size_ - k) - 1) / 2;
        // The frame of a side starts at the corner after it: at the odd corner, or at the apex.
        std::int64_t row = odd_corner == 2 ? odd : 0, column = odd_corner == 2 ? 0 : odd;
        if (!own) row = n - 1 - row, column = n - 1 - column;
        wing(k) = from[slot_position(refinement, half, row, column)];
      }
    }
  }

  Topology mesh_;
  const Record* base_;
  PredictionRule rule_;
  int refinement_;
  std::int64_t size_, stride_;
  Record* points_;
};

PLAIT_END_NAMESPACE
