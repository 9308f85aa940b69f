// plait/kernels/edge_grid.h: the two faces of an edge as one regular grid.
//
//        end (0,N)------(N,N) apex of the other face
//           | \   other   |            points (p, q), 0 <= p, q <= N = 2^level
//           |   \         |            p and q are the weights of the edge's start and end,
//           |     \       |            in the other face N minus these
//           |  own  \     |            the edge is the diagonal p + q = N
//   apex (0,0)------(N,0) start
//
// Neighbours of a point, counterclockwise: (+1,0) (0,+1) (-1,+1) (-1,0) (0,-1) (+1,-1). The
// vertices in the edge's slot at level l are the points with p = (2 row + 1) 2^(level-l) and q = (2
// column + 1) 2^(level-l). So their one-rings are inside the grid: a kernel gathers the grid once,
// and then every rule is plain arithmetic on an array. The grid of a border edge has only its own
// face. Levels count how often the base mesh is refined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/edge_index.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// An object is used for many edges, one after another, so that it allocates memory only once. Each
/// thread has its own.
template <class Record>
class EdgeGrid {
 public:
  /// Resizes the grid for `level`, with one more row of points around it. The contents are then
  /// undefined.
  void resize(int level) {
    level_ = level;
    size_ = std::int64_t{1} << level;
    stride_ = size_ + 3;
    // One extra record, because reading the last record with a whole vector register reads beyond
    // it.
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

/// Calls visit(row, first, step, n) for every row of the slot at `level`. `first` is the grid point
/// of the row's column 0, and `step` leads from one column to the next. In border slots, rows end
/// before column n.
template <class Record, class Visit>
void for_each_slot_row(const EdgeGrid<Record>& grid, int level, Visit visit) {
  const std::int64_t n = slot_side(level);
  const std::int64_t scale = std::int64_t{1} << (grid.level() - level);
  for (std::int64_t row = 0; row < n; ++row)
    visit(row, grid.at((2 * row + 1) * scale, scale), 2 * scale, n);
}

PLAIT_END_NAMESPACE
