// plait/detail/drawn_triangles.h: the triangles of a face that may have deeper neighbours. Where
// the face across a side is deeper, its vertices on the side are corners of triangles of this face
// too, so that no gap is left (docs/adaptive.md).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vertex_numbering.h"

PLAIT_BEGIN_NAMESPACE

/// Refinements of a face and of the faces across its sides.
struct DrawnDepths {
  int face = 0;
  /// [side]; at least `face`: a shallower neighbour, or none, is as deep as the face here.
  std::array<int, 3> sides{};

  /// Points of triangles are those of the face's grid at this level.
  int grid() const { return std::max({face, sides[0], sides[1], sides[2]}); }
  bool is_plain() const { return grid() == face; }
  std::uint64_t triangle_count() const {
    std::uint64_t count = std::uint64_t{1} << (2 * face);
    for (const int side : sides) count += (std::uint64_t{1} << side) - (std::uint64_t{1} << face);
    return count;
  }
};

/// Those of a face if depth(face) tells how deep each one is drawn.
template <class Depth>
DrawnDepths drawn_depths(const Topology& mesh, FaceId face, Depth depth) {
  DrawnDepths drawn;
  drawn.face = depth(face);
  for (int side = 0; side < 3; ++side) {
    const FaceSide beyond = mesh.across(FaceSide(face, side));
    drawn.sides[static_cast<std::size_t>(side)] =
        beyond.exists() ? std::max<int>(drawn.face, depth(beyond.face())) : drawn.face;
  }
  return drawn;
}

/// Calls visit(a, b, c) for the triangles of the triangle abc, counterclockwise as abc. `halvings`:
/// how often the sides ab, bc and ca are halved. Of several such sides the one with the most points
/// is cut first, so that no triangle has its corners on one side. One such side gives a fan.
template <class Visit>
void for_each_part_of_triangle(FacePoint a, FacePoint b, FacePoint c, std::array<int, 3> halvings,
                               Visit& visit) {
  const auto most = std::max_element(halvings.begin(), halvings.end());
  if (*most == 0) {
    visit(a, b, c);
    return;
  }
  if (most == halvings.begin() + 1)
    return for_each_part_of_triangle(b, c, a, {halvings[1], halvings[2], halvings[0]}, visit);
  if (most == halvings.begin() + 2)
    return for_each_part_of_triangle(c, a, b, {halvings[2], halvings[0], halvings[1]}, visit);
  const FacePoint middle{(a.i + b.i) / 2, (a.j + b.j) / 2};
  for_each_part_of_triangle(a, middle, c, {halvings[0] - 1, 0, halvings[2]}, visit);
  for_each_part_of_triangle(middle, b, c, {halvings[0] - 1, halvings[1], 0}, visit);
}

/// The triangles into which triangle (i, j), (i + 1, j), (i, j + 1) of the face's own level is
/// divided.
template <class Visit>
void for_each_part_of_upright(const DrawnDepths& depths, std::int64_t i, std::int64_t j,
                              Visit& visit) {
  const std::int64_t size = std::int64_t{1} << depths.face;
  const int shift = depths.grid() - depths.face;
  const auto halvings = [&](int side, bool touches) {
    return touches ? depths.sides[static_cast<std::size_t>(side)] - depths.face : 0;
  };
  const auto at = [&](std::int64_t x, std::int64_t y) { return FacePoint{x << shift, y << shift}; };
  for_each_part_of_triangle(
      at(i, j), at(i + 1, j), at(i, j + 1),
      {halvings(2, j == 0), halvings(0, i + j + 1 == size), halvings(1, i == 0)}, visit);
}

/// Calls visit(a, b, c) for the triangles of a face, counterclockwise: points of the grid at level
/// depths.grid(). Calls row_done() after each row of the face's own triangles.
template <class Visit, class RowDone>
void for_each_drawn_triangle(const DrawnDepths& depths, Visit visit, RowDone row_done) {
  const std::int64_t size = std::int64_t{1} << depths.face;
  const int shift = depths.grid() - depths.face;
  const auto at = [&](std::int64_t x, std::int64_t y) { return FacePoint{x << shift, y << shift}; };
  for (std::int64_t j = 0; j < size; ++j) {
    for (std::int64_t i = 0; i + j < size; ++i) {
      for_each_part_of_upright(depths, i, j, visit);
      if (i + j + 1 < size) visit(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
    row_done();
  }
}

PLAIT_END_NAMESPACE
