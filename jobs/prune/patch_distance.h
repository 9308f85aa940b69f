// prune/patch_distance.h: how far the vertices of a patch are from what is drawn of a coarser one.
#pragma once

#include <cstdint>
#include <vector>

#include "distance/closest_point.h"
#include "plait/detail/drawn_triangles.h"
#include "plait/detail/namespace.h"
#include "plait/reader.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The vertices of one face after another. For one thread.
class PatchDistance {
 public:
  /// `levels`: refinements of the face. Distances beyond `tolerance` are not told apart.
  PatchDistance(int levels, double tolerance);

  /// `at(i, j)` gives the position of a vertex of the finest level.
  template <class At>
  void fill(At at) {
    std::size_t next = 0;
    for (std::int64_t j = 0; j <= size_; ++j)
      for (std::int64_t i = 0; i + j <= size_; ++i) vertices_[next++] = at(i, j);
  }

  bool is_near(double distance) const { return distance <= tolerance_; }
  /// The largest distance of a vertex from the triangles that are drawn of the face with these
  /// depths; any number beyond the tolerance if one is farther. Of the triangles it looks at those
  /// near the vertex on the grid, so the distance may be less than the number says, never more. A
  /// position that is not a number is infinitely far.
  double distance(const DrawnDepths& depths) const;

 private:
  const Point& at(std::int64_t i, std::int64_t j) const {
    return vertices_[static_cast<std::size_t>(patch_vertex(size_, i, j))];
  }
  double squared_distance(const DrawnDepths& depths, std::int64_t i, std::int64_t j,
                          std::int64_t reach) const;

  std::int64_t size_;
  int levels_;
  double tolerance_;
  std::vector<Point> vertices_;  ///< in row order
};

PLAIT_END_NAMESPACE
