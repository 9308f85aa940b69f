#include "sample/turned.h"

#include <algorithm>
#include <array>
#include <cstddef>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether all three points are on one face, in its orientation. Points on a sharp edge may belong
/// to the face beyond it, whose normal says nothing about a triangle on this side.
bool lie_on_one_face(const Surface& scan, const std::array<SurfacePoint, 3>& points) {
  const auto is_on = [&](const SurfacePoint& point, FaceId face) {
    for (std::size_t i = 0; i < 3; ++i)
      if (point.weights[i] > 0 &&
          std::ranges::find(scan.faces[face], scan.faces[point.face][i]) == scan.faces[face].end())
        return false;
    return true;
  };
  const Point normal = area_vector(position_of(scan, points[0]), position_of(scan, points[1]),
                                   position_of(scan, points[2]));
  for (const SurfacePoint& point : points)
    for (int side = -1; side < 3; ++side) {
      FaceId face = point.face;
      if (side >= 0) {
        const FaceSide beyond = scan.across[FaceSide(point.face, side).code];
        if (!beyond.exists()) continue;
        face = beyond.face();
      }
      if (std::ranges::all_of(points, [&](const SurfacePoint& p) { return is_on(p, face); }))
        return dot(normal, face_normal(scan, face)) >= 0;
    }
  return false;
}

/// Calls work(face) for the other faces that a point belongs to: none, one, or those of a vertex.
template <class Work>
void for_each_other_face(const Surface& scan, const SurfacePoint& point, const Work& work) {
  for (int side = 0; side < 3; ++side) {
    if (point.weights[static_cast<std::size_t>(side)] > 0) continue;
    // Around the ends of this side that have weight, up to the point's face or a border.
    const FaceSide beyond = scan.across[FaceSide(point.face, side).code];
    if (!beyond.exists()) continue;
    work(beyond.face());
    for (const int step : {1, 2}) {
      if (point.weights[static_cast<std::size_t>((side + step) % 3)] < 1) continue;
      // The side that turns around the vertex is `step` after the one that was crossed.
      FaceSide at = beyond;
      for (;;) {
        at = scan.across[FaceSide(at.face(), (at.side() + step) % 3).code];
        if (!at.exists() || at.face() == point.face) break;
        work(at.face());
      }
    }
  }
}

/// The largest cosine between `normal`, of length 1, and a face that the point belongs to.
double nearest_cosine(const Surface& scan, const SurfacePoint& point, Point normal) {
  double nearest = dot(normal, face_normal(scan, point.face));
  for_each_other_face(scan, point, [&](FaceId face) {
    nearest = std::max(nearest, dot(normal, face_normal(scan, face)));
  });
  return nearest;
}

}  // namespace

bool is_turned(const Surface& scan, const SurfacePoint& a, const SurfacePoint& b,
               const SurfacePoint& c, bool has_creases) {
  const Point normal =
      area_vector(position_of(scan, a), position_of(scan, b), position_of(scan, c));
  const Point expected =
      face_normal(scan, a.face) + face_normal(scan, b.face) + face_normal(scan, c.face);
  if (dot(normal, expected) >= 0 || lie_on_one_face(scan, {a, b, c})) return false;
  if (!has_creases) return true;
  constexpr double kRounding = 1e-9;
  double sum = 0;
  for (const SurfacePoint* const point : {&a, &b, &c})
    sum += nearest_cosine(scan, *point, normalized(normal));
  return sum < kRounding;
}

std::uint64_t count_turned(const Surface& scan, const BaseMesh& base, int level,
                           std::span<const SurfacePoint> samples) {
  std::uint64_t count = 0;
  for_each_turned(scan, base, level, samples, false,
                  [&](FaceId, std::uint64_t, std::uint64_t, std::uint64_t) { ++count; });
  return count;
}

void weigh_turned_faces(const Surface& scan, const BaseMesh& base, int level,
                        std::span<const SurfacePoint> samples, bool has_creases, float factor,
                        std::vector<float>& weights) {
  const SampleNumbers numbers(base, level);
  std::vector<std::uint8_t> near(scan.positions.size(), 0);
  FaceId last = kNoId;
  for_each_turned(scan, base, level, samples, has_creases,
                  [&](FaceId face, std::uint64_t, std::uint64_t, std::uint64_t) {
                    if (face == last) return;
                    last = face;
                    numbers.for_each_triangle(
                        face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
                          for (const std::uint64_t sample : {a, b, c})
                            for (const VertexId vertex : scan.faces[samples[sample].face])
                              near[vertex] = 1;
                        });
                  });
  for (std::size_t vertex = 0; vertex < near.size(); ++vertex)
    if (near[vertex] != 0) weights[vertex] *= factor;
}

PLAIT_END_NAMESPACE
