// The two faces of an edge as one regular grid.
//
//        end (0,N)------(N,N) apex of the other face
//           | \   other   |            points (p, q), 0 <= p, q <= N = 2^level
//           |   \         |            p and q are the weights of the edge's start and end,
//           |     \       |            in the other face N minus these
//           |  own  \     |            the edge is the diagonal p + q = N
//   apex (0,0)------(N,0) start
//
// Neighbours of a point, counterclockwise: (+1,0) (0,+1) (-1,+1) (-1,0) (0,-1) (+1,-1). The
// vertices in the edge's slot at level l are the points with p = (2 row + 1) 2^(level-l) and
// q = (2 column + 1) 2^(level-l), so their one-rings never leave the grid: gather once, then every
// rule is plain arithmetic on an array. A border edge has only its own half. Levels count how often
// the base mesh is refined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/base_relative_level.h"
#include "plait/edge_index.h"
#include "plait/sweep.h"
#include "plait/topology.h"

namespace plait {

/// Storage is kept from edge to edge. One per thread.
template <class Record>
class Diamond {
 public:
  /// Makes a grid of `level`, with one more row of points around it. Contents are undefined.
  void resize(int level) {
    level_ = level;
    size_ = std::int64_t{1} << level;
    stride_ = size_ + 3;
    // One record more, for reads of a whole vector register at the last one.
    points_.resize(static_cast<std::size_t>(stride_ * stride_) + 1);
  }

  int level() const { return level_; }
  std::int64_t size() const { return size_; }
  std::int64_t stride() const { return stride_; }  ///< from (p, q) to (p + 1, q)
  Record* at(std::int64_t p, std::int64_t q) {
    return points_.data() + (p + 1) * stride_ + (q + 1);
  }
  const Record* at(std::int64_t p, std::int64_t q) const {
    return points_.data() + (p + 1) * stride_ + (q + 1);
  }

 private:
  int level_ = 0;
  std::int64_t size_ = 1, stride_ = 4;
  std::vector<Record> points_;
};

/// Where a gather takes its records from: an access of a sweep that reaches the edge's faces. As in
/// a diamond, levels count refinements of the base mesh.
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

/// Calls visit(row, first, step, n) for every row of the slot at `level`: its vertex of column 0 in
/// the grid and the step from one column to the next. Border slots end their rows before column n.
template <class Record, class Visit>
void for_each_slot_row(const Diamond<Record>& diamond, int level, Visit visit) {
  const std::int64_t n = slot_side(level);
  const std::int64_t scale = std::int64_t{1} << (diamond.level() - level);
  for (std::int64_t row = 0; row < n; ++row)
    visit(row, diamond.at((2 * row + 1) * scale, scale), 2 * scale, n);
}

/// The vertices that one face has in the slots of one of its sides, copied into the half of the
/// diamond that the face is, as seen from `side`. `turned` says that the face is the other one.
template <class Record>
void gather_side(const Topology& mesh, const SlotSource<Record>& source, FaceSide side, bool turned,
                 int slots_of, int level, Diamond<Record>& diamond) {
  const FaceId face = side.face();
  const EdgeId edge_id = mesh.face_edges[face][static_cast<std::size_t>(slots_of)];
  const Edge& edge = mesh.edges[edge_id];
  const std::int64_t n = slot_side(level), size = diamond.size(), stride = diamond.stride();
  const std::int64_t scale = std::int64_t{1} << (diamond.level() - level), both = 2 * scale;
  // Where row 0, column 0 goes in the grid, and what a row and a column further add. On the edge's
  // own side p follows the row and q the column; on the next one q follows the row, and on the last
  // one p the column, while the third weight makes up for it.
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
  Record* to = diamond.at(0, 0) + first;
  if (turned) {
    to = diamond.at(size, size) - first;
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

/// Fills `diamond` for `edge` with the vertices born at levels `first` to `last` (0: the base
/// vertices) at their places in a grid of `diamond.level()`.
template <class Record>
void gather(const Topology& mesh, const SlotSource<Record>& source, std::span<const Record> base,
            EdgeId edge, int first, int last, Diamond<Record>& diamond) {
  const std::int64_t size = diamond.size();
  for (const bool turned : {false, true}) {
    const FaceSide side = turned ? mesh.edges[edge].other : mesh.edges[edge].own;
    if (!side.exists()) continue;
    if (first == 0) {
      const auto& corners = mesh.faces[side.face()];
      const auto corner = [&](int turn) {
        return base[corners[static_cast<std::size_t>((side.side() + turn) % 3)]];
      };
      *diamond.at(turned ? size : 0, turned ? size : 0) = corner(0);
      *diamond.at(turned ? 0 : size, turned ? size : 0) = corner(1);
      *diamond.at(turned ? size : 0, turned ? 0 : size) = corner(2);
    }
    for (int level = std::max(first, 1); level <= last; ++level)
      for (int slots_of = 0; slots_of < 3; ++slots_of)
        gather_side(mesh, source, side, turned, slots_of, level, diamond);
  }
}

}  // namespace plait
