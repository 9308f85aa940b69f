// plait/detail/edge_grid.h: the two faces of an edge as one regular grid, and where the slots of
// their edges are in it.
//
//        end (0,N)------(N,N) apex of the other face
//           | \   other   |            points (p, q), 0 <= p, q <= N = 2^level
//           |   \         |            p and q are the weights of the edge's start and end,
//           |     \       |            in the other face N minus these
//           |  own  \     |            the edge is the diagonal p + q = N
//   apex (0,0)------(N,0) start        one more row of points lies around
//
// Neighbours of a point, counterclockwise: (+1,0) (0,+1) (-1,+1) (-1,0) (0,-1) (+1,-1). The
// vertices in the edge's slot at level l are the points with p = (2 row + 1) 2^(level-l) and q = (2
// column + 1) 2^(level-l). So their one-rings are inside the grid: a kernel gathers the grid once,
// and then every rule is plain arithmetic on an array. The grid of a border edge has only its own
// face. Levels count how often the base mesh is refined.
// Pinned by tests/engine/address/adaptive_depth_test.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/face_depths.h"
#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The places of the points of a grid in an array.
struct GridShape {
  int level = 0;
  std::int64_t size = 1;
  std::int64_t stride = 4;  ///< from (p, q) to (p + 1, q)

  GridShape() = default;
  explicit GridShape(int of_level)
      : level(of_level), size(std::int64_t{1} << of_level), stride(size + 3) {}
  std::size_t point_count() const { return static_cast<std::size_t>(stride * stride); }
  /// For p and q from -1 to size + 1.
  std::int64_t place(std::int64_t p, std::int64_t q) const { return (p + 1) * stride + (q + 1); }
};

/// What a face has of the slot of one of its sides: the half from the slot's start or from its end,
/// or a half slot. The two faces at the edge of a grid together have its whole slot.
enum class SlotView : std::uint8_t { kOwn, kOther, kHalf, kWhole };

/// A side of one of the two faces of a grid, counted counterclockwise from the side that is the
/// edge of the grid.
struct GridSide {
  bool turned;  ///< of the other face
  int turn;     ///< 0 to 2
  SlotView view;
};

/// Where the rows of a slot are in a grid. Points count from the point (0, 0).
struct SlotInGrid {
  std::int64_t first;  ///< the point of row 0, column 0
  std::int64_t row_step, column_step;
  std::int64_t to_neighbour;  ///< to the coarser neighbours of a vertex, in both directions
};

inline SlotInGrid slot_in_grid(const GridShape& grid, const GridSide& side, int level) {
  const std::int64_t scale = std::int64_t{1} << (grid.level - level), both = 2 * scale;
  const std::int64_t size = grid.size, stride = grid.stride;
  // On the side of the grid's edge, p increases with the row and q with the column. On the next
  // side q increases with the row, and on the last side p with the column; the third weight,
  // opposite the edge, changes accordingly.
  SlotInGrid at{scale * stride + scale, both * stride, both, scale * stride - scale};
  if (side.turn == 1)
    at = {(size - both) * stride + scale, both - both * stride, -both * stride, scale};
  else if (side.turn == 2)
    at = {scale * stride + (size - both), -both, both * stride - both, scale * stride};
  if (side.turned) {
    at.first = size * stride + size - at.first;
    at.row_step = -at.row_step;
    at.column_step = -at.column_step;
  }
  return at;
}

/// Calls visit(point, position in the slot) for the vertices of a slot at `level` that a grid has.
template <class Visit>
void for_each_in_grid(const GridShape& grid, const GridSide& side, int level, Visit visit) {
  const SlotInGrid at = slot_in_grid(grid, side, level);
  const std::int64_t n = slot_side(level), step = side.view == SlotView::kOther ? -1 : 1;
  std::int64_t to = at.first, from = step < 0 ? n * n - 1 : 0;
  for (std::int64_t row = 0; row < n; ++row) {
    const std::int64_t columns = side.view == SlotView::kWhole ? n : n - row;
    for (std::int64_t column = 0; column < columns; ++column)
      visit(to + column * at.column_step, from + column * step);
    to += at.row_step;
    from += side.view == SlotView::kHalf ? columns : n * step;
  }
}

/// Calls visit(point, vertex) for the corners of the face whose side `side` is the edge of the
/// grid. `turned`: it is the other face.
template <class Visit>
void for_each_corner(const Topology& mesh, const GridShape& grid, FaceSide side, bool turned,
                     Visit visit) {
  const auto corner = [&](int turn) {
    return mesh.faces[side.face()][static_cast<std::size_t>((side.side() + turn) % 3)];
  };
  const std::int64_t p = grid.size * grid.stride, q = grid.size;
  visit(turned ? p + q : 0, corner(0));
  visit(turned ? q : p, corner(1));
  visit(turned ? p : q, corner(2));
}

/// The records of the points. An object is used for many edges, one after another, so that it
/// allocates memory only once. Each thread has its own.
template <class Record>
class EdgeGrid {
 public:
  /// Resizes the grid for `level`, with one more row of points around it. The contents are then
  /// undefined.
  void resize(int level) {
    shape_ = GridShape(level);
    // One extra record, because reading the last record with a whole vector register reads beyond
    // it.
    points_.resize(shape_.point_count() + 1);
  }

  const GridShape& shape() const { return shape_; }
  int level() const { return shape_.level; }
  std::int64_t size() const { return shape_.size; }
  std::int64_t stride() const { return shape_.stride; }
  Record* at(std::int64_t p, std::int64_t q) { return points_.data() + shape_.place(p, q); }
  const Record* at(std::int64_t p, std::int64_t q) const {
    return points_.data() + shape_.place(p, q);
  }

 private:
  GridShape shape_;
  std::vector<Record> points_;
};

/// Calls visit(row, first, step, n) for every row of the slot at `level`. `first` is the grid point
/// of the row's column 0, and `step` leads from one column to the next. The shape of the slot says
/// where the row ends.
template <class Record, class Visit>
void for_each_slot_row(const EdgeGrid<Record>& grid, int level, Visit visit) {
  const std::int64_t n = slot_side(level);
  const std::int64_t scale = std::int64_t{1} << (grid.level() - level);
  for (std::int64_t row = 0; row < n; ++row)
    visit(row, grid.at((2 * row + 1) * scale, scale), 2 * scale, n);
}

/// Levels of the faces of an edge: all from `first` to `last`, or those of them that the face has.
struct FaceLevels {
  int first = 0, last = 0;
  const FaceDepths* depths = nullptr;  ///< nullptr: every face has all of them

  int last_of(FaceId face) const noexcept {
    return depths == nullptr ? last : std::min(last, depths->of(face));
  }
};

/// Calls corner(point, vertex) for the base vertices of the faces of `edge` if levels.first is 0,
/// and record(point, slot, position) for the vertices that `levels` create on these faces. Points
/// count from the point (0, 0). `slot_of(level, edge)` gives the slot of an edge of its faces:
/// anything that has a member `shape`.
template <class SlotOf, class Corner, class PutRecord>
void for_each_place_around(const Topology& mesh, EdgeId edge, const GridShape& grid,
                           const SlotOf& slot_of, const FaceLevels& levels, Corner corner,
                           PutRecord record) {
  for (const bool turned : {false, true}) {
    const FaceSide side = turned ? mesh.edges[edge].other : mesh.edges[edge].own;
    if (!side.exists()) continue;
    if (levels.first == 0) for_each_corner(mesh, grid, side, turned, corner);
    const int last = levels.last_of(side.face());
    for (int level = std::max(levels.first, 1); level <= last; ++level)
      for (int turn = 0; turn < 3; ++turn) {
        const FaceSide at(side.face(), (side.side() + turn) % 3);
        const EdgeId of = mesh.face_edges[at.face()][static_cast<std::size_t>(at.side())];
        const auto slot = slot_of(level, of);
        // A half slot is that of the one face that has it, whichever face this is.
        const SlotView view = slot.shape == SlotShape::kHalf ? SlotView::kHalf
                              : mesh.edges[of].own == at     ? SlotView::kOwn
                                                             : SlotView::kOther;
        for_each_in_grid(
            grid, {turned, turn, view}, level,
            [&](std::int64_t point, std::int64_t position) { record(point, slot, position); });
      }
  }
}

/// Calls put(point, record) for these vertices. `source.slot(level, edge)` gives the SlotRecords.
template <class Record, class Source, class Put>
void for_each_around(const Topology& mesh, EdgeId edge, const GridShape& grid,
                     std::span<const Record> base, const Source& source, const FaceLevels& levels,
                     Put put) {
  for_each_place_around(
      mesh, edge, grid, [&](int level, EdgeId of) { return source.slot(level, of); }, levels,
      [&](std::int64_t point, VertexId vertex) { put(point, base[vertex]); },
      [&](std::int64_t point, const SlotRecords<const Record>& slot, std::int64_t position) {
        put(point, slot.data()[position]);
      });
}

/// Fills `grid` with these vertices, at their places in a grid of level grid.level().
template <class Record, class Source>
void gather(const Topology& mesh, const Source& source, std::span<const Record> base, EdgeId edge,
            const FaceLevels& levels, EdgeGrid<Record>& grid) {
  for_each_around(mesh, edge, grid.shape(), base, source, levels,
                  [points = grid.at(0, 0)](std::int64_t point, const Record& record) {
                    points[point] = record;
                  });
}

PLAIT_END_NAMESPACE
