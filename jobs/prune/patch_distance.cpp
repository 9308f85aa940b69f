#include "prune/patch_distance.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

constexpr double kKeptBack = 1.0 / 32;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The neighbours of a point of a grid, counterclockwise.
constexpr FacePoint kRing[] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};

}  // namespace

PatchDistance::PatchDistance(int levels, double tolerance)
    : size_(std::int64_t{1} << levels),
      levels_(levels),
      tolerance_(tolerance * (1 - kKeptBack)),
      vertices_(patch_vertex_count(size_)),
      offsets_(vertices_.size()) {}

/// From the triangles in the cells of the face's own grid that are at most `reach` cells away.
double PatchDistance::squared_distance(const DrawnDepths& depths, std::int64_t i, std::int64_t j,
                                       std::int64_t reach) const {
  const Point p = at(i, j);
  double least = kInfinity;
  const int finer = levels_ - depths.grid();
  const auto offer = [&](FacePoint a, FacePoint b, FacePoint c) {
    const Point q =
        closest_of_triangle(p, at(a.i << finer, a.j << finer), at(b.i << finer, b.j << finer),
                            at(c.i << finer, c.j << finer));
    least = std::min(least, squared_length(p - q));
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

/// Calls visit(a, b, c, whether it is part of a fan) for each drawn triangle, with its corners in
/// the grid of the finest level.
template <class Visit>
void PatchDistance::for_each_triangle_of(const DrawnDepths& depths, Visit visit) const {
  const int finer = levels_ - depths.grid();
  const std::int64_t side = std::int64_t{1} << (depths.grid() - depths.face);
  const auto is_side = [side](FacePoint from, FacePoint to) {
    return std::max(std::abs(to.i - from.i), std::abs(to.j - from.j)) == side;
  };
  for_each_drawn_triangle(
      depths,
      [&](FacePoint a, FacePoint b, FacePoint c) {
        const bool in_fan = !is_side(a, b) || !is_side(b, c) || !is_side(c, a);
        for (FacePoint* corner : {&a, &b, &c}) *corner = {corner->i << finer, corner->j << finer};
        visit(a, b, c, in_fan);
      },
      [] {});
}

/// Most vertices are nearer than the farthest one even from the point at the same place of the
/// grid. Then no closest point is computed for them.
void PatchDistance::find_offsets(const DrawnDepths& depths) {
  std::ranges::fill(offsets_, kInfinity);
  largest_offsets_.clear();
  const std::int64_t steps = std::int64_t{1} << (levels_ - depths.face);
  const double step = 1 / static_cast<double>(steps);
  for_each_triangle_of(depths, [&](FacePoint a, FacePoint b, FacePoint c, bool in_fan) {
    if (in_fan) {
      largest_offsets_.push_back(kInfinity);
      return;
    }
    const Point origin = at(a.i, a.j), ab = at(b.i, b.j) - origin, ac = at(c.i, c.j) - origin;
    const FacePoint to_b{(b.i - a.i) / steps, (b.j - a.j) / steps},
        to_c{(c.i - a.i) / steps, (c.j - a.j) / steps};
    double largest = 0;
    for (std::int64_t v = 0; v <= steps; ++v)
      for (std::int64_t u = 0; u + v <= steps; ++u) {
        const auto vertex = static_cast<std::size_t>(
            patch_vertex(size_, a.i + u * to_b.i + v * to_c.i, a.j + u * to_b.j + v * to_c.j));
        const Point p =
            origin + (step * static_cast<double>(u)) * ab + (step * static_cast<double>(v)) * ac;
        const double offset = squared_length(vertices_[vertex] - p);
        // A position that is no number has no offset, and is looked at.
        const double known = offset >= 0 ? offset : kInfinity;
        offsets_[vertex] = std::min(offsets_[vertex], known);
        largest = std::max(largest, known);
      }
    largest_offsets_.push_back(largest);
  });
}

double PatchDistance::squared_distance_of_vertices(const DrawnDepths& depths) const {
  const int coarser = levels_ - depths.face;
  const std::int64_t mask = (std::int64_t{1} << coarser) - 1;
  const auto look = [&](std::int64_t i, std::int64_t j, double offset) {
    const double squared = std::min(squared_distance(depths, i, j, 0), offset);
    // A vertex may have moved along the surface, beyond the triangles of its own cell.
    return is_far(squared) ? squared_distance(depths, i, j, 1) : squared;
  };
  // The vertex that is probably the farthest comes first.
  double most = 0, largest = 0;
  FacePoint first{0, 0};
  std::size_t vertex = 0;
  for (std::int64_t j = 0; j <= size_; ++j)
    for (std::int64_t i = 0; i + j <= size_; ++i, ++vertex)
      if (const double offset = offsets_[vertex]; offset > largest && offset < kInfinity) {
        largest = offset;
        first = {i, j};
      }
  if (largest > 0) most = look(first.i, first.j, largest);
  if (is_far(most)) return kInfinity;
  vertex = 0;
  for (std::int64_t j = 0; j <= size_; ++j)
    for (std::int64_t i = 0; i + j <= size_; ++i, ++vertex) {
      if (offsets_[vertex] <= most) continue;
      if (((i | j) & mask) == 0 && std::isfinite(at(i, j).x + at(i, j).y + at(i, j).z))
        continue;  // a corner of triangles
      const double squared = look(i, j, offsets_[vertex]);
      if (is_far(squared)) return kInfinity;
      most = std::max(most, squared);
    }
  return most;
}

/// From the triangles of the finest level around the vertex that is nearest among its neighbours,
/// on a way of vertices that begins at `start`.
double PatchDistance::squared_distance_from_finest(const Point& p, FacePoint start) const {
  const auto has = [&](std::int64_t i, std::int64_t j) { return (i | j | (size_ - i - j)) >= 0; };
  FacePoint nearest = start;
  double least = squared_length(at(start.i, start.j) - p);
  for (bool moves = true; moves;) {
    moves = false;
    const FacePoint from = nearest;
    for (const FacePoint& step : kRing) {
      const std::int64_t i = from.i + step.i, j = from.j + step.j;
      if (!has(i, j)) continue;
      const double squared = squared_length(at(i, j) - p);
      if (!(squared < least)) continue;
      least = squared;
      nearest = {i, j};
      moves = true;
    }
  }
  const Point centre = at(nearest.i, nearest.j);
  for (std::size_t each = 0; each < std::size(kRing); ++each) {
    const FacePoint& b = kRing[each];
    const FacePoint& c = kRing[(each + 1) % std::size(kRing)];
    if (!has(nearest.i + b.i, nearest.j + b.j) || !has(nearest.i + c.i, nearest.j + c.j)) continue;
    const Point q = closest_of_triangle(p, centre, at(nearest.i + b.i, nearest.j + b.j),
                                        at(nearest.i + c.i, nearest.j + c.j));
    least = std::min(least, squared_length(q - p));
  }
  return least;
}

/// Or `most`, if it is larger.
double PatchDistance::squared_distance_of_drawn(const DrawnDepths& depths, double most) const {
  const std::int64_t steps = std::int64_t{1} << (levels_ - depths.face);
  const double step = 1 / static_cast<double>(steps);
  std::size_t triangle = 0;
  for_each_triangle_of(depths, [&](FacePoint a, FacePoint b, FacePoint c, bool) {
    if (largest_offsets_[triangle++] <= most) return;
    const Point origin = at(a.i, a.j), ab = at(b.i, b.j) - origin, ac = at(c.i, c.j) - origin;
    for (std::int64_t v = 0; v <= steps && !is_far(most); ++v)
      for (std::int64_t u = 0; u + v <= steps; ++u) {
        if (v == steps || u == steps || (u | v) == 0) continue;  // a corner is a vertex
        const Point p =
            origin + (step * static_cast<double>(u)) * ab + (step * static_cast<double>(v)) * ac;
        // In a fan the place on the grid is between two vertices.
        const auto place = [&](std::int64_t from, std::int64_t to_b, std::int64_t to_c) {
          return (from * steps + u * (to_b - from) + v * (to_c - from)) / steps;
        };
        const FacePoint start{place(a.i, b.i, c.i), place(a.j, b.j, c.j)};
        if (squared_length(at(start.i, start.j) - p) <= most) continue;
        most = std::max(most, squared_distance_from_finest(p, start));
      }
  });
  return is_far(most) ? kInfinity : most;
}

double PatchDistance::distance(const DrawnDepths& depths) {
  find_offsets(depths);
  const double of_vertices = squared_distance_of_vertices(depths);
  if (is_far(of_vertices)) return kInfinity;
  return std::sqrt(squared_distance_of_drawn(depths, of_vertices));
}

PLAIT_END_NAMESPACE
