// backends/compressed/filters/edge_lattice.h: the coarser vertices around the slot of an edge, as a
// regular grid.
//
//        end (0,N)------(N,N) apex of the other face
//           | \   other   |            points (p, q), 0 <= p, q <= N = 2^(level-1)
//           |   \         |            p and q are the weights of the edge's start and end,
//           |     \       |            in the other face N minus these
//           |  own  \     |            the edge is the diagonal p + q = N
//   apex (0,0)------(N,0) start        one more row of points lies around
//
// The vertex (row, column) of the slot lies between the points A = (row, column + 1) and B = (row +
// 1, column). slot_predictions.h predicts it from these and the points around. Irregular vertices
// get no rule of their own: a prediction need not be smooth.
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
#include "compressed/filters/lattice_places.h"
#include "plait/edge_index.h"
#include "plait/namespace.h"
#include "plait/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

  /// From the levels before places.refinement(), the levels of the slots. `memory` has bytes()
  /// bytes. `base` are the records of the base vertices.
  EdgeLattice(const CoarserBlocks& levels, const LatticePlaces& places,
              std::span<const std::byte> base, std::span<std::byte> memory)
      : mesh_(levels.mesh()),
        places_(places),
        base_(reinterpret_cast<const Record*>(base.data())),
        refinement_(places.refinement()),
        size_(slot_side(refinement_)),
        stride_(size_ + 3),
        points_(reinterpret_cast<Record*>(memory.data())) {}

  /// Has the processor fetch what gather() will read for this edge: most of it is in the slots of
  /// the last level. Their lines are read in too many orders for the processor to foresee.
  void prefetch(const CoarserSlots& slots, EdgeId edge) const {
    const int last = refinement_ - 1;
    const auto bytes_of_slot =
        static_cast<std::int64_t>(sizeof(Record)) * (size_ / 2) * (size_ / 2);
    if (last < 1 || bytes_of_slot < kLeastFetched) return;
    for (const FaceSide side : {mesh_.edges[edge].own, mesh_.edges[edge].other}) {
      if (!side.exists()) continue;
      for (const EdgeId each : mesh_.face_edges[side.face()])
        if (const std::byte* const bytes = slots.slot(last, each); bytes != nullptr)
          for (std::int64_t i = 0; i < bytes_of_slot; i += kCacheLine)
            __builtin_prefetch(bytes + i);
    }
  }
  /// Fills the points around the edge, but not the row around them.
  void gather(const CoarserSlots& slots, EdgeId edge) {
    std::array<Side, 5> sides;
    std::size_t count = 0;
    // The edge itself comes first. Its whole slot lies between the two faces.
    const bool border = mesh_.edges[edge].is_border();
    sides[count++] = {edge, {false, 0, border ? SlotView::kHalf : SlotView::kWhole}};
    for (const bool turned : {false, true}) {
      const FaceSide side = turned ? mesh_.edges[edge].other : mesh_.edges[edge].own;
      if (!side.exists()) continue;
      gather_corners(side, turned);
      for (int turn = 1; turn < 3; ++turn) sides[count++] = side_of(side, turned, turn);
    }
    // A vertex that is not known is replaced by coarser ones, so those come first.
    for (int refinement = 1; refinement < refinement_; ++refinement)
      for (const Side& side : std::span(sides).first(count)) gather_slot(slots, side, refinement);
  }
  /// Fills the row around the points. REQUIRES: gather() has filled the points.
  void gather_wings(const CoarserSlots& slots, EdgeId edge) {
    for (const bool turned : {false, true}) {
      const FaceSide side = turned ? mesh_.edges[edge].other : mesh_.edges[edge].own;
      if (!side.exists()) continue;
      for (const bool beyond_start : {true, false}) gather_wings(slots, side, turned, beyond_start);
    }
  }
  const Record* point(std::int64_t p, std::int64_t q) const {
    return points_ + (p + 1) * stride_ + (q + 1);
  }
  std::int64_t side() const { return size_; }
  std::int64_t stride() const { return stride_; }  ///< from (p, q) to (p + 1, q)
  /// Room for stride() records.
  Record* spare() { return points_ + stride_ * stride_; }

 private:
  static constexpr std::int64_t kCacheLine = 64, kLeastFetched = 4 * kCacheLine;

  /// One of the sides of the two faces.
  struct Side {
    EdgeId edge;
    SidePlace place;
  };

  Record* at(std::int64_t p, std::int64_t q) { return points_ + (p + 1) * stride_ + (q + 1); }

  void gather_corners(FaceSide side, bool turned) {
    const auto& corners = mesh_.faces[side.face()];
    const auto corner = [&](int turn) {
      return base_[corners[static_cast<std::size_t>((side.side() + turn) % 3)]];
    };
    *at(turned ? size_ : 0, turned ? size_ : 0) = corner(0);
    *at(turned ? 0 : size_, turned ? size_ : 0) = corner(1);
    *at(turned ? size_ : 0, turned ? 0 : size_) = corner(2);
  }
  Side side_of(FaceSide side, bool turned, int turn) const {
    const int slots_of = (side.side() + turn) % 3;
    const EdgeId edge = mesh_.face_edges[side.face()][static_cast<std::size_t>(slots_of)];
    const Edge& there = mesh_.edges[edge];
    const SlotView view = there.is_border()                              ? SlotView::kHalf
                          : there.own == FaceSide(side.face(), slots_of) ? SlotView::kOwn
                                                                         : SlotView::kOther;
    return {edge, {turned, turn, view}};
  }

  /// Copies the vertices of one face that are in the slot of one of its sides.
  void gather_slot(const CoarserSlots& slots, const Side& side, int refinement) {
    const std::byte* const bytes = slots.slot(refinement, side.edge);
    Record* const points = at(0, 0);
    if (bytes == nullptr) [[unlikely]] {
      const std::int64_t to_neighbour = places_.rows(side.place, refinement).to_neighbour;
      return places_.visit(side.place, refinement, [&](std::int64_t to, std::int64_t) {
        for (std::size_t k = 0; k < kComponents; ++k)
          points[to][k] =
              Number(0.5) * (points[to + to_neighbour][k] + points[to - to_neighbour][k]);
      });
    }
    const auto* const from = reinterpret_cast<const Record*>(bytes);
    if (refinement <= LatticePlaces::kMostListed)
      for (const auto& place : places_.listed(side.place, refinement))
        points[place.to] = from[place.from];
    else
      places_.visit(side.place, refinement,
                    [&](std::int64_t to, std::int64_t at_slot) { points[to] = from[at_slot]; });
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
      if (bytes == nullptr) [[unlikely]] {
        for (std::int64_t k = first; k <= size_; k += 2) continue_at(k);
        continue;
      }
      // The frame of a side starts at the corner after it: at the odd corner, or at the apex. So
      // the vertices are column 0 of the slot, or row 0, from its end on or from its start.
      const bool own = edge.own == FaceSide(beyond.face(), slots_of), by_row = odd_corner == 2;
      const Record* from = reinterpret_cast<const Record*>(bytes);
      Record* to = &wing(first);
      const std::int64_t to_step = (turned ? -2 : 2) * (beyond_start ? 1 : stride_);
      if (by_row && edge.is_border()) {
        for (std::int64_t i = 0; i < n; ++i, to += to_step)
          *to = from[slot_position(refinement, true, far_is_odd ? i : n - 1 - i, 0)];
        continue;
      }
      std::int64_t step = by_row ? n : 1;
      if (!own) from += n * n - 1, step = -step;
      if (!far_is_odd) from += (n - 1) * step, step = -step;
      for (std::int64_t i = 0; i < n; ++i, from += step, to += to_step) *to = *from;
    }
  }

  Topology mesh_;
  const LatticePlaces& places_;
  const Record* base_;
  int refinement_;
  std::int64_t size_, stride_;
  Record* points_;
};

PLAIT_END_NAMESPACE
