// backends/compressed/filters/edge_lattice.h: the coarser vertices around the slot of an edge, as
// the edge's grid (plait/detail/edge_grid.h) of the level before. Unlike gather() there, it
// works when some slots are missing, and prefetches base records.
//
// The vertex (row, column) of the slot lies between the points A = (row, column + 1) and B = (row +
// 1, column). slot_predictions.h predicts it from these and the points around. Irregular vertices
// get no rule of their own: a prediction need not be smooth.
//
// A point that is not known is replaced: a vertex of a level that its face does not have, or in the
// slot of an edge that is in no chosen block, by the midpoint of its coarser neighbours; a wing
// beyond a border, or in such a slot, by the continuation of the triangle inside.
// Pinned by tests/backends/compressed/filters/hierarchy_filter_test.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "compressed/filters/coarser_blocks.h"
#include "compressed/filters/lattice_places.h"
#include "compressed/filters/surrounding_edges.h"
#include "plait/detail/edge_grid.h"
#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For one thread: it visits every edge of a range in turn.
template <class Number, std::size_t kComponents>
class EdgeLattice {
 public:
  using Record = std::array<Number, kComponents>;

  /// The memory of a lattice for slots of `refinement`.
  static std::size_t bytes(int refinement) {
    const GridShape grid(refinement - 1);
    return sizeof(Record) * (grid.point_count() + static_cast<std::size_t>(grid.stride));
  }

  /// From the levels up to that of places.grid(), the levels of the slots. `memory` has bytes()
  /// bytes. `base` are the records of the base vertices. Without `has_wings` the row around the
  /// points is not filled.
  EdgeLattice(const CoarserBlocks& levels, const CoarserSlots& slots, const LatticePlaces& places,
              std::span<const std::byte> base, std::span<std::byte> memory,
              const EdgesOfBlock& edges, bool has_wings)
      : mesh_(levels.mesh()),
        depths_(levels.depths()),
        slots_(slots),
        places_(places),
        base_(reinterpret_cast<const Record*>(base.data())),
        grid_(places.grid()),
        refinement_(grid_.level + 1),
        size_(grid_.size),
        points_(reinterpret_cast<Record*>(memory.data())),
        has_wings_(has_wings),
        edges_(mesh_, depths_, edges, base.data(), sizeof(Record),
               !has_wings         ? SurroundingEdgesAhead::Beyond::kNothing
               : refinement_ == 1 ? SurroundingEdgesAhead::Beyond::kCorner
                                  : SurroundingEdgesAhead::Beyond::kStrips) {
    for (std::size_t at = 0; at < kComplete; ++at) find_slots(at);
  }

  /// Fills the points around the next edge. Returns false after the last one.
  bool next() {
    if (next_ == edges_.count()) return false;
    edges_.advance_to(next_);
    find_slots(next_ + kComplete);
    gather(edges_[next_], found_[next_ % kFound]);
    ++next_;
    return true;
  }
  /// The edge whose points are filled, and whether it is a border.
  EdgeId edge() const { return edges_[next_ - 1].edge; }
  bool is_border() const { return edges_[next_ - 1].is_border; }
  const Record* point(std::int64_t p, std::int64_t q) const { return points_ + grid_.place(p, q); }
  std::int64_t side() const { return size_; }
  std::int64_t stride() const { return grid_.stride; }  ///< from (p, q) to (p + 1, q)
  /// Room for stride() records.
  Record* spare() { return points_ + grid_.point_count(); }

 private:
  static constexpr std::size_t kComplete = SurroundingEdgesAhead::kComplete, kFound = 4;
  static_assert(kComplete < kFound);

  using Side = SurroundingEdges::Side;
  using FoundSlot = CoarserSlots::Found;

  /// Slots around an edge; null where they are in no chosen block.
  struct FoundSlots {
    /// [refinement - 1][0 for the edge itself, 1 + its place among the sides]
    std::array<std::array<FoundSlot, 5>, kMostCoarserBlocks> of_level;
    std::array<std::array<FoundSlot, 2>, 4> strips;  ///< of the last level: [side][strip]
  };

  /// Larger slots have long rows, whose lines the processor foresees by itself.
  static constexpr std::int64_t kCacheLine = 64, kMostFetched = 64 * kCacheLine;
  static void fetch(const FoundSlot& slot, std::int64_t slot_bytes) {
    if (slot.bytes == nullptr || slot_bytes > kMostFetched) return;
    for (std::int64_t i = 0; i < slot_bytes; i += kCacheLine) __builtin_prefetch(slot.bytes + i);
  }
  static std::int64_t slot_bytes(int refinement) {
    return static_cast<std::int64_t>(sizeof(Record)) << (2 * (refinement - 1));
  }
  bool has(FaceSide side, int refinement) const {
    return depths_ == nullptr || depths_->of(side.face()) >= refinement;
  }
  /// The slot of an edge of a face; null too if the face does not have the level. Then a half slot
  /// is that of the next face.
  FoundSlot slot_of(FaceSide side, int refinement, EdgeId edge) const {
    return has(side, refinement) ? slots_.slot(refinement, edge) : FoundSlot{};
  }
  /// Finds the slots of an edge that comes soon, and has the processor fetch what gather() will
  /// read: their lines are read in too many orders for the processor to foresee.
  void find_slots(std::size_t at) {
    if (at >= edges_.count()) return;
    const SurroundingEdges& around = edges_[at];
    FoundSlots& found = found_[at % kFound];
    for (int refinement = 1; refinement < refinement_; ++refinement) {
      auto& slots = found.of_level[static_cast<std::size_t>(refinement - 1)];
      const std::int64_t bytes = slot_bytes(refinement);
      slots[0] = slots_.slot(refinement, around.edge);
      fetch(slots[0], bytes);
      for (std::size_t i = 0; i < around.sides().size(); ++i) {
        slots[1 + i] = slot_of(around.faces[i / 2], refinement, around.all_sides[i].edge);
        fetch(slots[1 + i], bytes);
      }
    }
    if (!has_wings_ || refinement_ == 1) return;
    for (std::size_t i = 0; i < around.sides().size(); ++i) {
      const Side& side = around.all_sides[i];
      if (!side.beyond.exists()) continue;
      for (std::size_t strip = 0; strip < 2; ++strip) {
        found.strips[i][strip] = slot_of(side.beyond, refinement_ - 1, side.strips[strip].edge);
        fetch(found.strips[i][strip], slot_bytes(refinement_ - 1));
      }
    }
  }

  void gather(const SurroundingEdges& around, const FoundSlots& found) {
    for (const FaceSide side : around.faces)
      if (side.exists())
        for_each_corner(
            mesh_, grid_, side, side != around.faces[0],
            [&](std::int64_t point, VertexId vertex) { at(0, 0)[point] = base_[vertex]; });
    // A vertex that is not known is replaced by coarser ones, so those come first. The edge itself
    // has its whole slot between the two faces, or a half slot in the first one. What the other
    // face would have of a whole slot is not read then: of this face only the row of points next to
    // the edge is, and none of them, nor of those that replace them, is in the edge's slot.
    const GridSide own{false, 0, SlotView::kWhole};
    const bool is_turned = around.faces[0] != mesh_.edges[around.edge].own;
    for (int refinement = 1; refinement < refinement_; ++refinement) {
      const auto& slots = found.of_level[static_cast<std::size_t>(refinement - 1)];
      if (is_turned && slots[0].shape == SlotShape::kWhole) [[unlikely]] {
        gather_slot(slots[0], {false, 0, SlotView::kOther}, refinement);
        gather_slot(slots[0], {true, 0, SlotView::kOwn}, refinement);
      } else {
        gather_slot(slots[0], own, refinement);
      }
      for (std::size_t i = 0; i < around.sides().size(); ++i)
        gather_slot(slots[1 + i], around.all_sides[i].place, refinement);
    }
    if (!has_wings_) return;
    for (std::size_t i = 0; i < around.sides().size(); ++i)
      gather_wing(around.all_sides[i], found.strips[i]);
  }

  Record* at(std::int64_t p, std::int64_t q) { return points_ + grid_.place(p, q); }

  /// Copies the vertices of one face that are in the slot of one of its sides.
  void gather_slot(const FoundSlot& slot, GridSide side, int refinement) {
    if (slot.shape == SlotShape::kHalf) side.view = SlotView::kHalf;
    const std::byte* const bytes = slot.bytes;
    Record* const points = at(0, 0);
    if (bytes == nullptr) [[unlikely]] {
      const std::int64_t to_neighbour = slot_in_grid(grid_, side, refinement).to_neighbour;
      return for_each_in_grid(grid_, side, refinement, [&](std::int64_t to, std::int64_t) {
        for (std::size_t k = 0; k < kComponents; ++k)
          points[to][k] =
              Number(0.5) * (points[to + to_neighbour][k] + points[to - to_neighbour][k]);
      });
    }
    const auto* const from = reinterpret_cast<const Record*>(bytes);
    auto* const to_bytes = reinterpret_cast<std::byte*>(points);
    if (places_.is_listed(refinement))
      for (const auto& place : places_.listed(side, refinement))
        std::memcpy(to_bytes + place.to, bytes + place.from, sizeof(Record));
    else
      for_each_in_grid(grid_, side, refinement,
                       [&](std::int64_t to, std::int64_t at_slot) { points[to] = from[at_slot]; });
  }

  /// Fills the points (-1, k) or (k, -1), 1 <= k <= N, beyond a face, in the face's own frame. They
  /// are the points with weight 1 of the next face's apex, and have the weights k - 1 and N - k of
  /// the ends of the edge between. Of this edge, k counts from the apex of the lattice on.
  void gather_wing(const Side& side, const std::array<FoundSlot, 2>& strips) {
    // The side opposite the start is the one after the edge's side.
    const bool turned = side.place.turned, beyond_start = side.place.turn == 1;
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
    const FaceSide beyond = side.beyond;
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
      const auto which = static_cast<std::size_t>(odd_corner - 1);
      const auto& [bytes, shape] = strips[which];
      const bool is_half = shape == SlotShape::kHalf;
      if (bytes == nullptr) [[unlikely]] {
        for (std::int64_t k = first; k <= size_; k += 2) continue_at(k);
        continue;
      }
      // The frame of a side starts at the corner after it: at the odd corner, or at the apex. So
      // the vertices are column 0 of the slot, or row 0, from its end on or from its start.
      const bool by_row = odd_corner == 2;
      const Record* from = reinterpret_cast<const Record*>(bytes);
      Record* to = &wing(first);
      const std::int64_t to_step = (turned ? -2 : 2) * (beyond_start ? 1 : grid_.stride);
      if (by_row && is_half) {
        for (std::int64_t i = 0; i < n; ++i, to += to_step)
          *to = from[slot_position(refinement, shape, far_is_odd ? i : n - 1 - i, 0)];
        continue;
      }
      std::int64_t step = by_row ? n : 1;
      if (!side.strips[which].is_own && !is_half) from += n * n - 1, step = -step;
      if (!far_is_odd) from += (n - 1) * step, step = -step;
      for (std::int64_t i = 0; i < n; ++i, from += step, to += to_step) *to = *from;
    }
  }

  Topology mesh_;
  const FaceDepths* depths_;  ///< null: all faces have all levels
  const CoarserSlots& slots_;
  const LatticePlaces& places_;
  const Record* base_;
  GridShape grid_;
  int refinement_;
  std::int64_t size_;
  Record* points_;
  bool has_wings_;
  SurroundingEdgesAhead edges_;
  std::size_t next_ = 0;  ///< in the range of edges
  std::array<FoundSlots, kFound> found_ = {};
};

PLAIT_END_NAMESPACE
