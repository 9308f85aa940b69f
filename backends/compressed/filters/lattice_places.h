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

#include "plait/detail/edge_grid.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

  /// For the slots of `refinement`, with records of this size.
  LatticePlaces(int refinement, std::size_t record_bytes);

  /// That of a grid of the next coarser level.
  const GridShape& grid() const noexcept { return grid_; }

  bool is_listed(int refinement) const noexcept { return refinement <= listed_; }
  /// The vertices of a side that are born at a coarser refinement. REQUIRES: is_listed(refinement).
  std::span<const Place> listed(const GridSide& side, int refinement) const noexcept {
    return lists_[index(side)][static_cast<std::size_t>(refinement - 1)];
  }

 private:
  static std::size_t index(const GridSide& side) noexcept {
    const int index = (side.turned ? 12 : 0) + 4 * side.turn + static_cast<int>(side.view);
    return static_cast<std::size_t>(index);
  }

  GridShape grid_;
  int listed_;
  std::vector<Place> places_;
  std::array<std::array<std::span<const Place>, kMostListed>, 24> lists_;  ///< [index()]
};

PLAIT_END_NAMESPACE
