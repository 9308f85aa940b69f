// plait/extend/edge_index.h: where a vertex of a semi-regular mesh is stored.
//
//   face index (face, level, i, j)          i, j >= 0, i + j <= 2^level
//        c (0,2^L)                           corner a = (0,0), b = (2^L,0), c = (0,2^L)
//        |  `.                               weights k0 = 2^L - i - j, k1 = i, k2 = j
//        |     `.
//   a (0,0)----b (2^L,0)
//
//   edge index (edge, level, row, column)   row, column in [0, n), n = 2^(level-1)
//
// Every vertex except the corners is created at one level l and belongs to one base edge. In the
// frame of side x of the face, row and column count from the edge's start and end: k_(x+1) = 2 row
// + 1 and k_(x+2) = 2 column + 1 at level l. Points inside the face have row + column < n - 1;
// points on the edge itself have row + column = n - 1. Seen from the face on the other side of the
// edge, (row, column) is (n - 1 - row, n - 1 - column).
//
// Source: I. Guskov, "Non-replicating indexing for out-of-core processing of semi-regular
// triangular surface meshes", section 2. Pinned by tests/engine/address/edge_index_test.cpp.
// All functions are constexpr, branch-light, thread-safe and never fail; levels run to kMaxLevel.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// A point of the grid of a face: the corners are (0, 0), (2^level, 0) and (0, 2^level).
struct FaceIndex {
  FaceId face = 0;
  int level = 0;
  std::int64_t i = 0, j = 0;
  friend constexpr bool operator==(const FaceIndex&, const FaceIndex&) = default;
};

/// Where a vertex is stored: in the slot of `edge` at the level that created the vertex, at this
/// row and column.
struct EdgeIndex {
  EdgeId edge = 0;
  int level = 1;
  std::int64_t row = 0, column = 0;
  friend constexpr bool operator==(const EdgeIndex&, const EdgeIndex&) = default;
};

/// An edge index in the frame of one side of one face. This frame may differ from the edge's own
/// frame.
struct SideIndex {
  int side = 0;
  int level = 1;
  std::int64_t row = 0, column = 0;
  friend constexpr bool operator==(const SideIndex&, const SideIndex&) = default;
};

/// Rows (and columns) of a slot: 2^(level-1). REQUIRES: level >= 1.
constexpr std::int64_t slot_side(int level) { return std::int64_t{1} << (level - 1); }

/// Which records of an edge's grid at one level the edge's slot has (plait/detail/slot_shapes.h).
enum class SlotShape : std::uint8_t {
  kWhole,   ///< n x n records, n = slot_side(level)
  kHalf,    ///< n(n+1)/2 records: the triangle of the one face that has the level
  kAbsent,  ///< none: the slot has no bytes
};

/// Records of the slot in row `row`, of n rows.
constexpr std::int64_t row_records(SlotShape shape, std::int64_t n, std::int64_t row) {
  return shape == SlotShape::kWhole ? n : shape == SlotShape::kHalf ? n - row : 0;
}

constexpr std::uint64_t slot_records(int level, SlotShape shape = SlotShape::kWhole) {
  const auto n = static_cast<std::uint64_t>(slot_side(level));
  return shape == SlotShape::kWhole ? n * n : shape == SlotShape::kHalf ? n * (n + 1) / 2 : 0;
}

/// Position of (row, column) inside its slot, in records. A slot stores one row after another.
/// REQUIRES: the slot has this record.
constexpr std::int64_t slot_position(int level, SlotShape shape, std::int64_t row,
                                     std::int64_t column) {
  const std::int64_t n = slot_side(level);
  return shape == SlotShape::kHalf ? row * n - row * (row - 1) / 2 + column : row * n + column;
}

/// A place in a slot.
struct SlotPoint {
  std::int64_t row = 0, column = 0;
};
/// The inverse of slot_position(). REQUIRES: the slot has a record at `position`.
constexpr SlotPoint slot_point(int level, SlotShape shape, std::int64_t position) {
  const std::int64_t n = slot_side(level);
  if (shape != SlotShape::kHalf) return {position / n, position % n};
  std::int64_t row = 0, after = n;
  while (after - row > 1) {
    const std::int64_t middle = (row + after) / 2;
    (slot_position(level, shape, middle, 0) <= position ? row : after) = middle;
  }
  return {row, position - slot_position(level, shape, row, 0)};
}

/// Whether (i, j) at `level` is a corner of the face: a base vertex.
constexpr bool is_corner(int level, std::int64_t i, std::int64_t j) {
  const std::int64_t size = std::int64_t{1} << level;
  return (i == 0 || i == size) && (j == 0 || j == size);
}

/// Which corner (0, 1, 2) a corner point is. REQUIRES: is_corner(level, i, j).
constexpr int corner_of(std::int64_t i, std::int64_t j) { return i > 0 ? 1 : j > 0 ? 2 : 0; }

/// The point at a corner of the face.
constexpr FaceIndex corner_point(FaceId face, int level, int corner) {
  const std::int64_t size = std::int64_t{1} << level;
  return {face, level, corner == 1 ? size : 0, corner == 2 ? size : 0};
}

/// Face coordinates to the frame of a side. REQUIRES: the point is in the face and no corner.
constexpr SideIndex to_side(int level, std::int64_t i, std::int64_t j) {
  const int shift = std::countr_zero(static_cast<std::uint64_t>(i | j));
  const int born = level - shift;
  const std::int64_t k[3] = {(std::int64_t{1} << born) - (i >> shift) - (j >> shift), i >> shift,
                             j >> shift};
  // Exactly one of the three weights is even: the weight of the corner opposite the side.
  const int side = (k[1] & 1) == 0 ? 1 : (k[2] & 1) == 0 ? 2 : 0;
  return {side, born, (k[(side + 1) % 3] - 1) / 2, (k[(side + 2) % 3] - 1) / 2};
}

/// The inverse of to_side: face coordinates at the level that creates the vertex. REQUIRES: row +
/// column <= n - 1.
constexpr FaceIndex from_side(FaceId face, const SideIndex& index) {
  std::int64_t k[3] = {};
  k[(index.side + 1) % 3] = 2 * index.row + 1;
  k[(index.side + 2) % 3] = 2 * index.column + 1;
  k[index.side] = (std::int64_t{1} << index.level) - 2 * (index.row + index.column) - 2;
  return {face, index.level, k[1], k[2]};
}

/// Face index to edge index. REQUIRES: the point is in the face and no corner.
constexpr EdgeIndex edge_index(const Topology& mesh, const FaceIndex& point) {
  const SideIndex at = to_side(point.level, point.i, point.j);
  const EdgeId edge = mesh.face_edges[point.face][static_cast<std::size_t>(at.side)];
  if (mesh.is_own(point.face, at.side)) return {edge, at.level, at.row, at.column};
  const std::int64_t last = slot_side(at.level) - 1;
  return {edge, at.level, last - at.row, last - at.column};
}

/// Edge index to face index, at the level that creates the vertex. The result is in the edge's own
/// face if the point lies there (points on the edge itself do), else in the other face.
constexpr FaceIndex face_index(const Topology& mesh, const EdgeIndex& index) {
  const Edge& edge = mesh.edges[index.edge];
  const std::int64_t last = slot_side(index.level) - 1;
  if (index.row + index.column <= last)
    return from_side(edge.own.face(), {edge.own.side(), index.level, index.row, index.column});
  return from_side(edge.other.face(),
                   {edge.other.side(), index.level, last - index.row, last - index.column});
}

/// The same point at another level of refinement. REQUIRES: the point exists at that level.
constexpr FaceIndex at_level(const FaceIndex& point, int level) {
  return level >= point.level ? FaceIndex{point.face, level, point.i << (level - point.level),
                                          point.j << (level - point.level)}
                              : FaceIndex{point.face, level, point.i >> (point.level - level),
                                          point.j >> (point.level - level)};
}

/// The side of the face beyond which a point lies: the side opposite its negative weight. -1 for a
/// point of the face.
constexpr int side_beyond(const FaceIndex& point) {
  const std::int64_t k0 = (std::int64_t{1} << point.level) - point.i - point.j;
  return k0 < 0 ? 0 : point.i < 0 ? 1 : point.j < 0 ? 2 : -1;
}

/// Converts a point outside the face, in the face's lattice continued across side x, to coordinates
/// of the face across that side. REQUIRES: there is a face across side x, and the point lies in it
/// when both faces are unfolded into one plane.
constexpr FaceIndex unfold(const Topology& mesh, const FaceIndex& point, int side) {
  const FaceSide beyond = mesh.across(FaceSide(point.face, side));
  const std::int64_t size = std::int64_t{1} << point.level;
  const std::int64_t k[3] = {size - point.i - point.j, point.i, point.j};
  std::int64_t there[3] = {};
  there[(beyond.side() + 1) % 3] = size - k[(side + 1) % 3];
  there[(beyond.side() + 2) % 3] = size - k[(side + 2) % 3];
  there[beyond.side()] = -k[side];
  return {beyond.face(), point.level, there[1], there[2]};
}

/// Applies unfold() across one side after another, until the point lies in a face. The result's
/// face is kNoId if a border edge is in between. REQUIRES: every base vertex in between has valence
/// 6. Stencils of vertices that are not base vertices satisfy this.
constexpr FaceIndex unfold_fully(const Topology& mesh, FaceIndex point) {
  for (int side = side_beyond(point); side >= 0; side = side_beyond(point)) {
    if (!mesh.across(FaceSide(point.face, side)).exists()) return {kNoId, point.level, 0, 0};
    point = unfold(mesh, point, side);
  }
  return point;
}

PLAIT_END_NAMESPACE
