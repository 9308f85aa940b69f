#include "sample/turned.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

bool is_turned(const Surface& scan, const SurfacePoint& a, const SurfacePoint& b,
               const SurfacePoint& c) {
  const Point normal =
      area_vector(position_of(scan, a), position_of(scan, b), position_of(scan, c));
  const Point expected =
      face_normal(scan, a.face) + face_normal(scan, b.face) + face_normal(scan, c.face);
  return dot(normal, expected) < 0;
}

std::uint64_t count_turned(const Surface& scan, const BaseMesh& base, int level,
                           std::span<const SurfacePoint> samples) {
  std::uint64_t count = 0;
  for_each_turned(scan, base, level, samples,
                  [&](FaceId, std::uint64_t, std::uint64_t, std::uint64_t) { ++count; });
  return count;
}

void weigh_turned_faces(const Surface& scan, const BaseMesh& base, int level,
                        std::span<const SurfacePoint> samples, float factor,
                        std::vector<float>& weights) {
  const SampleNumbers numbers(base, level);
  std::vector<std::uint8_t> near(scan.positions.size(), 0);
  FaceId last = kNoId;
  for_each_turned(
      scan, base, level, samples, [&](FaceId face, std::uint64_t, std::uint64_t, std::uint64_t) {
        if (face == last) return;
        last = face;
        numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          for (const std::uint64_t sample : {a, b, c})
            for (const VertexId vertex : scan.faces[samples[sample].face]) near[vertex] = 1;
        });
      });
  for (std::size_t vertex = 0; vertex < near.size(); ++vertex)
    if (near[vertex] != 0) weights[vertex] *= factor;
}

PLAIT_END_NAMESPACE
