// plait/detail/ring_runs.h: which rings the vertices of a slot have in the grid of their edge
// (plait/detail/edge_grid.h). Programs use plait/visit_vertices.h.
//
// A vertex has the ring of the finest level that all faces around it have. In a store whose faces
// have depths of their own (docs/adaptive.md), the two faces of an edge may differ in it, so a row
// of a slot has up to three runs: the vertices inside the own face, the one on the edge, and those
// inside the other face. A vertex that lies on the edge and that only one of the two faces has gets
// the ring of this face, as on a border.
// Pinned by tests/kernels/visit_depths_test.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_NAMESPACE

/// How often the faces of an edge are refined, at most as often as a visit goes. At a border edge
/// both numbers are those of its one face.
struct EdgeDepths {
  int own = 0, other = 0;

  int deeper() const noexcept { return std::max(own, other); }
  int shallower() const noexcept { return std::min(own, other); }
  friend bool operator==(const EdgeDepths&, const EdgeDepths&) = default;
};

/// The part of a ring that a vertex has: all of it, or the half in one face.
enum class RingExtent : std::uint8_t { kWhole, kOwnFace, kOtherFace };

/// Vertices of one row of a slot, one after another in the slot, whose rings are alike.
struct RingRun {
  std::size_t position = 0;  ///< of the first vertex in its slot
  std::size_t count = 0;
  std::int64_t p = 0, q = 0;  ///< the point of the first vertex in the grid
  std::int64_t step = 1;      ///< of q, from one vertex to the next
  int depth = 0;              ///< how often the base mesh is refined where the ring is
  RingExtent extent = RingExtent::kWhole;
};

/// The neighbours of a point in a grid, counterclockwise. On a border the first and the last one
/// are on the border, too.
struct RingSteps {
  std::array<std::ptrdiff_t, 6> whole{};
  std::array<std::ptrdiff_t, 4> own{}, other{};

  RingSteps() = default;
  /// `spacing` is the distance of neighbours, in points of a grid with this stride.
  RingSteps(std::ptrdiff_t stride, std::ptrdiff_t spacing)
      : whole{stride, 1, 1 - stride, -stride, -1, stride - 1},
        own{1 - stride, -stride, -1, stride - 1},
        other{stride - 1, stride, 1, 1 - stride} {
    for (std::ptrdiff_t& step : whole) step *= spacing;
    for (std::ptrdiff_t& step : own) step *= spacing;
    for (std::ptrdiff_t& step : other) step *= spacing;
  }
  std::span<const std::ptrdiff_t> of(RingExtent extent) const noexcept {
    if (extent == RingExtent::kWhole) return whole;
    return extent == RingExtent::kOwnFace ? own : other;
  }
};

/// Calls visit(RingRun, std::bool_constant) for the vertices of a slot, row by row. The constant is
/// whether the rings are whole, so that what visits them can be compiled for six neighbours and for
/// four. The grid has the level depths.deeper(). `shape` is that of the slot at `refinement`.
template <class Visit>
void for_each_ring_run(const EdgeDepths& depths, SlotShape shape, int refinement, Visit visit) {
  if (shape == SlotShape::kAbsent) return;
  const std::int64_t n = slot_side(refinement);
  const std::int64_t scale = std::int64_t{1} << (depths.deeper() - refinement);
  const std::int64_t size = std::int64_t{1} << depths.deeper();
  // A half slot of the other face is stored in the frame of that face: turned by half a turn.
  const bool turned = shape == SlotShape::kHalf && depths.own < refinement;
  for (std::int64_t row = 0; row < n; ++row) {
    const auto run = [&](std::int64_t column, std::int64_t count, int depth, RingExtent extent) {
      RingRun of;
      of.position = static_cast<std::size_t>(slot_position(refinement, shape, row, column));
      of.count = static_cast<std::size_t>(count);
      of.p = (2 * row + 1) * scale;
      of.q = (2 * column + 1) * scale;
      of.step = 2 * scale;
      if (turned) {
        of.p = size - of.p;
        of.q = size - of.q;
        of.step = -of.step;
      }
      of.depth = depth;
      of.extent = extent;
      return of;
    };
    const std::int64_t edge = n - 1 - row;  // the column of the vertex on the edge
    // At most three runs of whole rings, and one of half a ring.
    struct Whole {
      std::int64_t column, count;
      int depth;
    };
    const bool is_half = shape == SlotShape::kHalf, is_even = depths.own == depths.other;
    const int of_half = turned ? depths.other : depths.own;
    const std::array<Whole, 3> whole = {
        {is_half   ? Whole{0, edge, of_half}
         : is_even ? Whole{0, n, depths.own}
                   : Whole{0, edge, depths.own},
         is_half || is_even ? Whole{} : Whole{edge, 1, depths.shallower()},
         is_half || is_even ? Whole{} : Whole{edge + 1, row, depths.other}}};
    for (const Whole& part : whole)
      if (part.count > 0)
        visit(run(part.column, part.count, part.depth, RingExtent::kWhole), std::true_type{});
    if (is_half)
      visit(run(edge, 1, of_half, turned ? RingExtent::kOtherFace : RingExtent::kOwnFace),
            std::false_type{});
  }
}

PLAIT_END_NAMESPACE
