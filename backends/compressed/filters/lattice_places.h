// backends/compressed/filters/lattice_places.h: where the vertices of a slot are among the points
// of an EdgeLattice. This depends on levels only, so it is found once for each level, and gathering
// the points of an edge is copying from a few lists. On coarse levels, where slots have a handful
// of vertices, that is most of the time that a filter takes. Pinned by
// tests/backends/compressed/filters/hierarchy_filter_test.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a face has of the slot of one of its sides: the half from the slot's start or from its end,
/// or the half slot of a border. Of the edge of a lattice, both faces together have the whole slot.
enum class SlotView : std::uint8_t { kOwn, kOther, kHalf, kWhole };

/// A side of one of the two faces at the edge of a lattice: the own face, or the other one, which
/// is turned; counted on from the side that is the edge itself, which is a side of the own face.
struct SidePlace {
  bool turned;
  int turn;
  SlotView view;
};

/// For lattices of slots of one level. Immutable and safe from any number of threads.
class LatticePlaces {
 public:
  /// Slots of these refinements have lists, if the lattice is not huge; larger slots are long
  /// enough for loops.
  static constexpr int kMostListed = 5, kLargestLattice = 12;

  /// One vertex: its point, counted from the point (0, 0), and its place in the slot, in bytes.
  struct Place {
    std::int32_t to, from;
  };
  /// The rows of a side among the points.
  struct Rows {
    std::int64_t first;  ///< the point of row 0, column 0
    std::int64_t row_step, column_step;
    std::int64_t to_neighbour;  ///< to the coarser neighbours of a vertex, in both directions
  };

  /// For the slots of `refinement`, with records of this size.
  LatticePlaces(int refinement, std::size_t record_bytes);

  int refinement() const noexcept { return refinement_; }

  bool is_listed(int refinement) const noexcept { return refinement <= listed_; }
  /// The vertices of a side that are born at a coarser refinement. REQUIRES: is_listed(refinement).
  std::span<const Place> listed(const SidePlace& side, int refinement) const noexcept {
    return lists_[index(side)][static_cast<std::size_t>(refinement - 1)];
  }
  Rows rows(const SidePlace& side, int refinement) const noexcept;
  /// Calls visit(point, place in the slot) for these vertices, for any coarser refinement.
  template <class Visit>
  void visit(const SidePlace& side, int refinement, Visit visit) const {
    const Rows rows = this->rows(side, refinement);
    const std::int64_t n = std::int64_t{1} << (refinement - 1);
    const std::int64_t step = side.view == SlotView::kOther ? -1 : 1;
    std::int64_t to = rows.first, from = step < 0 ? n * n - 1 : 0;
    for (std::int64_t row = 0; row < n; ++row) {
      const std::int64_t columns = side.view == SlotView::kWhole ? n : n - row;
      for (std::int64_t column = 0; column < columns; ++column)
        visit(to + column * rows.column_step, from + column * step);
      to += rows.row_step;
      from += side.view == SlotView::kHalf ? n - row : n * step;
    }
  }

 private:
  static std::size_t index(const SidePlace& side) noexcept {
    const int index = (side.turned ? 12 : 0) + 4 * side.turn + static_cast<int>(side.view);
    return static_cast<std::size_t>(index);
  }

  int refinement_, listed_;
  std::int64_t size_, stride_;
  std::vector<Place> places_;
  std::array<std::array<std::span<const Place>, kMostListed>, 24> lists_;  ///< [index()]
};

PLAIT_END_NAMESPACE
