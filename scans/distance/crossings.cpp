#include "distance/crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/threads.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kFacesOfThread = 64;
constexpr Pace kPaceOfParts{2, 2048};
/// Comparisons of two faces, of which a surface needs about 30 for each face.
constexpr std::uint64_t kMostPairsOfFace = 256;
/// Of lengths and areas: what is nearer only touches, so that rounding makes no crossing.
constexpr double kTouch = 1e-9;

using Corners = std::array<Point, 3>;

/// Whether the segment passes through the inside of the triangle.
bool passes(Point p, Point q, const Corners& triangle) {
  const Point normal = area_vector(triangle[0], triangle[1], triangle[2]);
  const Point from = p - triangle[0], to = q - triangle[0];
  const double above = dot(normal, from), below = dot(normal, to);
  const double touch = kTouch * length(normal) * length(q - p);
  if (!((above > touch && below < -touch) || (above < -touch && below > touch))) return false;
  const Point at = p + (above / (above - below)) * (q - p);
  const double edge = kTouch * dot(normal, normal);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Point a = triangle[corner], b = triangle[(corner + 1) % 3];
    if (!(dot(cross(b - a, at - a), normal) > edge)) return false;
  }
  return true;
}

/// Whether `other` has corners on both sides of the plane of `one`, which most near faces do not.
bool is_on_both_sides(const Corners& one, const Corners& other) {
  const Point normal = area_vector(one[0], one[1], one[2]);
  bool above = false, below = false;
  for (const Point& p : other) {
    const double side = dot(normal, p - one[0]);
    above = above || side > 0;
    below = below || side < 0;
  }
  return above && below;
}

bool cross_each_other(const Corners& one, const Corners& two) {
  if (!is_on_both_sides(one, two) || !is_on_both_sides(two, one)) return false;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    if (passes(one[corner], one[(corner + 1) % 3], two)) return true;
    if (passes(two[corner], two[(corner + 1) % 3], one)) return true;
  }
  return false;
}

bool have_a_vertex_in_common(const std::array<VertexId, 3>& one,
                             const std::array<VertexId, 3>& two) {
  return std::ranges::any_of(
      one, [&](VertexId vertex) { return std::ranges::find(two, vertex) != two.end(); });
}

/// A corner may be there twice, at a seam.
bool have_a_corner_in_common(const Corners& one, const Corners& two) {
  return std::ranges::any_of(
      one, [&](const Point& p) { return std::ranges::find(two, p) != two.end(); });
}

}  // namespace

Crossings find_crossings(const TriangleSet& triangles, const TriangleTree& tree,
                         const std::function<void()>& go_on, std::uint64_t most_pairs) {
  const std::size_t faces = triangles.faces.size();
  const auto corners_of = [&](FaceId face) {
    const auto& [a, b, c] = triangles.faces[face];
    return Corners{triangles.positions[a], triangles.positions[b], triangles.positions[c]};
  };
  // Returns how many faces it was compared with.
  const auto compare = [&](FaceId face, std::uint8_t& crosses) {
    const Corners own = corners_of(face);
    std::uint64_t compared = 0;
    tree.for_faces_in_box(own, [&](FaceId other) {
      ++compared;
      if (have_a_vertex_in_common(triangles.faces[face], triangles.faces[other])) return true;
      const Corners there = corners_of(other);
      if (have_a_corner_in_common(own, there) || !cross_each_other(own, there)) return true;
      crosses = 1;
      return false;
    });
    return compared;
  };
  const std::uint64_t most = most_pairs + kMostPairsOfFace * faces;
  std::vector<std::uint8_t> crosses(faces, 0);
  std::vector<std::uint64_t> compared((faces + kFacesOfThread - 1) / kFacesOfThread, 0);
  const auto compare_part = [&](std::size_t part) {
    const std::size_t start = part * kFacesOfThread;
    for (std::size_t face = start; face < std::min(start + kFacesOfThread, faces); ++face)
      if (compared[part] <= most)
        compared[part] += compare(static_cast<FaceId>(face), crosses[face]);
  };
  Crossings result;
  std::uint64_t sum = 0;
  std::size_t counted = 0;  // parts
  for_paced_ranges(
      compared.size(), kPaceOfParts,
      [&](std::size_t) {
        if (go_on) go_on();
      },
      [&](std::size_t first, std::size_t last) {
        if (sum > most) return;
        each_on_workers(first, last, compare_part);
        for (; counted < last && sum <= most; ++counted) sum += compared[counted];
      });
  // Which part exceeds the limit does not depend on the ranges.
  if (sum > most) --counted;
  result.examined = std::min(counted * kFacesOfThread, faces);
  crosses.resize(result.examined);
  result.faces = static_cast<std::uint64_t>(std::count(crosses.begin(), crosses.end(), 1));
  if (result.faces > 0) {
    const auto first = std::find(crosses.begin(), crosses.end(), 1) - crosses.begin();
    result.first = corners_of(static_cast<FaceId>(first))[0];
  }
  return result;
}

PLAIT_END_NAMESPACE
