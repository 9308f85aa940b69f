// prune/patch_distance.h: how far a patch and what is drawn of a coarser one are from each other.
#pragma once

#include <cmath>
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
  /// `levels`: refinements of the face. Distances beyond `tolerance` are not told apart. Of the
  /// tolerance a thirty-second is kept back for what lies between the points that are measured.
  PatchDistance(int levels, double tolerance);

  /// `at(i, j)` gives the position of a vertex of the finest level.
  template <class At>
  void fill(At at) {
    std::size_t next = 0;
    for (std::int64_t j = 0; j <= size_; ++j)
      for (std::int64_t i = 0; i + j <= size_; ++i) vertices_[next++] = at(i, j);
  }

  bool is_near(double distance) const { return distance <= tolerance_; }
  /// The larger one of two distances: of a vertex of the finest level from the triangles that are
  /// drawn of the face with these depths, and of a point of these triangles, as many as there are
  /// vertices, from the triangles of the finest level. Any number beyond the tolerance if one is
  /// farther. It looks at triangles of the same face near the point, so the distance may be less
  /// than the number says, never more. A position that is not a number is infinitely far.
  double distance(const DrawnDepths& depths);

 private:
  const Point& at(std::int64_t i, std::int64_t j) const {
    return vertices_[static_cast<std::size_t>(patch_vertex(size_, i, j))];
  }
  double squared_distance(const DrawnDepths& depths, std::int64_t i, std::int64_t j,
                          std::int64_t reach) const;
  bool is_far(double squared) const { return !(std::sqrt(squared) <= tolerance_); }
  template <class Visit>
  void for_each_triangle_of(const DrawnDepths& depths, Visit visit) const;
  void find_offsets(const DrawnDepths& depths);
  double squared_distance_of_vertices(const DrawnDepths& depths) const;
  double squared_distance_of_drawn(const DrawnDepths& depths, double most) const;
  double squared_distance_from_finest(const Point& p, FacePoint start) const;

  std::int64_t size_;
  int levels_;
  double tolerance_;
  std::vector<Point> vertices_;  ///< in row order
  /// Squared, of the vertices from the points of drawn triangles at the same place of the grid:
  /// [vertex in row order] infinity in a fan; and [triangle] the largest.
  std::vector<double> offsets_, largest_offsets_;
};

PLAIT_END_NAMESPACE
