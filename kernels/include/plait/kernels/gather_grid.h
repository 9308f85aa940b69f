// plait/kernels/gather_grid.h: fills the grid of an edge (plait/kernels/edge_grid.h) from the slots
// of all edges of its two faces. It reads each row of a slot in one contiguous run. Levels count
// refinements of the base mesh. Programs use plait/kernels/visit_vertices.h, which calls it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/base_relative_level.h"
#include "plait/edge_index.h"
#include "plait/kernels/edge_grid.h"
#include "plait/namespace.h"
#include "plait/sweep.h"
#include "plait/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The source of the records: an access of a sweep with Reach::kFaces or more.
template <class Record>
struct SlotSource {
  const SweepView& view;
  std::size_t access;
  int base_level;
  std::span<const Record> slot(int level, EdgeId edge) const {
    return view.records<const Record>(access, level_number(BaseRelativeLevel(level), base_level),
                                      edge);
  }
};

/// Copies vertices of one face to the grid: those in the slots of the face's side `slots_of`.
/// `side` is the face's side on the edge of the grid. `turned` tells that the face is the other
/// face of this edge. `source` has the function slot() of SlotSource.
template <class Record, class Source>
void gather_side(const Topology& mesh, const Source& source, FaceSide side, bool turned,
                 int slots_of, int level, EdgeGrid<Record>& grid) {
  const FaceId face = side.face();
  const EdgeId edge_id = mesh.face_edges[face][static_cast<std::size_t>(slots_of)];
  const Edge& edge = mesh.edges[edge_id];
  const std::int64_t n = slot_side(level), size = grid.size(), stride = grid.stride();
  const std::int64_t scale = std::int64_t{1} << (grid.level() - level), both = 2 * scale;
  // The place of (row 0, column 0) in the grid, and the steps for one more row and one more column.
  // On the side of the grid's edge, p increases with the row and q with the column. On the next
  // side q increases with the row, and on the last side p with the column; the third weight,
  // opposite the edge, changes accordingly.
  std::int64_t first = scale * stride + scale, row_step = both * stride, column_step = both;
  const int turn = slots_of - side.side() + (slots_of < side.side() ? 3 : 0);
  if (turn == 1) {
    first = (size - both) * stride + scale;
    row_step = both - both * stride;
    column_step = -both * stride;
  } else if (turn == 2) {
    first = scale * stride + (size - both);
    row_step = -both;
    column_step = both * stride - both;
  }
  Record* to = grid.at(0, 0) + first;
  if (turned) {
    to = grid.at(size, size) - first;
    row_step = -row_step;
    column_step = -column_step;
  }
  const Record* from = source.slot(level, edge_id).data();
  if (edge.own == FaceSide(face, slots_of)) {
    const bool triangle = edge.is_border();
    for (std::int64_t row = 0; row < n; ++row) {
      const std::int64_t columns = n - row;
      for (std::int64_t column = 0; column < columns; ++column)
        to[column * column_step] = from[column];
      to += row_step;
      from += triangle ? columns : n;
    }
  } else {
    from += n * n - 1;
    for (std::int64_t columns = n; columns > 0; --columns) {
      for (std::int64_t column = 0; column < columns; ++column)
        to[column * column_step] = from[-column];
      to += row_step;
      from -= n;
    }
  }
}

/// Fills `grid` for `edge` with the vertices that levels `first` to `last` create (0: the base
/// vertices), at their places in a grid of level grid.level().
template <class Record, class Source>
void gather(const Topology& mesh, const Source& source, std::span<const Record> base, EdgeId edge,
            int first, int last, EdgeGrid<Record>& grid) {
  const std::int64_t size = grid.size();
  for (const bool turned : {false, true}) {
    const FaceSide side = turned ? mesh.edges[edge].other : mesh.edges[edge].own;
    if (!side.exists()) continue;
    if (first == 0) {
      const auto& corners = mesh.faces[side.face()];
      const auto corner = [&](int turn) {
        return base[corners[static_cast<std::size_t>((side.side() + turn) % 3)]];
      };
      *grid.at(turned ? size : 0, turned ? size : 0) = corner(0);
      *grid.at(turned ? 0 : size, turned ? size : 0) = corner(1);
      *grid.at(turned ? size : 0, turned ? 0 : size) = corner(2);
    }
    for (int level = std::max(first, 1); level <= last; ++level)
      for (int slots_of = 0; slots_of < 3; ++slots_of)
        gather_side(mesh, source, side, turned, slots_of, level, grid);
  }
}

PLAIT_END_NAMESPACE
