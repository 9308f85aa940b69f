#include "prune/patch_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

PLAIT_BEGIN_PRIVATE_NAMESPACE

PatchDistance::PatchDistance(int levels, double tolerance)
    : size_(std::int64_t{1} << levels),
      levels_(levels),
      tolerance_(tolerance),
      vertices_(patch_vertex_count(size_)) {}

/// From the triangles in the cells of the face's own grid that are at most `reach` cells away.
double PatchDistance::squared_distance(const DrawnDepths& depths, std::int64_t i, std::int64_t j,
                                       std::int64_t reach) const {
  const Point p = at(i, j);
  double least = std::numeric_limits<double>::infinity();
  const int finer = levels_ - depths.grid();
  const auto offer = [&](FacePoint a, FacePoint b, FacePoint c) {
    const Point q =
        closest_of_triangle(p, at(a.i << finer, a.j << finer), at(b.i << finer, b.j << finer),
                            at(c.i << finer, c.j << finer));
    const double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
    if (const double squared = x * x + y * y + z * z; squared < least) least = squared;
  };
  const int coarser = levels_ - depths.face, shift = depths.grid() - depths.face;
  const std::int64_t cells = std::int64_t{1} << depths.face;
  const std::int64_t column = i >> coarser, row = j >> coarser;
  const auto corner = [&](std::int64_t x, std::int64_t y) {
    return FacePoint{x << shift, y << shift};
  };
  for (std::int64_t y = std::max<std::int64_t>(row - reach, 0); y <= row + reach; ++y)
    for (std::int64_t x = std::max<std::int64_t>(column - reach, 0); x <= column + reach; ++x) {
      if (x + y < cells) for_each_part_of_upright(depths, x, y, offer);
      if (x + y + 1 < cells) offer(corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
    }
  return least;
}

double PatchDistance::distance(const DrawnDepths& depths) const {
  const int coarser = levels_ - depths.face;
  const std::int64_t mask = (std::int64_t{1} << coarser) - 1;
  double most = 0;
  for (std::int64_t j = 0; j <= size_; ++j)
    for (std::int64_t i = 0; i + j <= size_; ++i) {
      if (((i | j) & mask) == 0 && std::isfinite(at(i, j).x + at(i, j).y + at(i, j).z))
        continue;  // a corner of triangles
      double squared = squared_distance(depths, i, j, 0);
      // A vertex may have moved along the surface, beyond the triangles of its own cell.
      if (!(std::sqrt(squared) <= tolerance_)) squared = squared_distance(depths, i, j, 1);
      if (!(std::sqrt(squared) <= tolerance_)) return std::numeric_limits<double>::infinity();
      most = std::max(most, squared);
    }
  return std::sqrt(most);
}

PLAIT_END_NAMESPACE
