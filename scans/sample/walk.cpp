#include <algorithm>
#include <cmath>

#include "sample/untangle.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A walk crosses at most so many faces.
constexpr int kMostFaces = 64;

/// The change of the barycentric coordinates along a vector in the plane of the face.
std::array<double, 3> weights_along(const Surface& scan, FaceId face, Point way) {
  const Point a = scan.corner(face, 0), b = scan.corner(face, 1), c = scan.corner(face, 2);
  const Point normal = area_vector(a, b, c);
  const double squared = dot(normal, normal);
  if (!(squared > 0)) return {0, 0, 0};
  const double db = dot(cross(normal, a - c), way) / squared;
  const double dc = dot(cross(normal, b - a), way) / squared;
  return {-db - dc, db, dc};
}

/// Turns `way` around the edge between two faces, as the first face turns into the second.
Point turned(Point way, Point along, Point from, Point to) {
  const Point axis = normalized(along);
  const Point out = cross(from, axis), next = cross(to, axis);
  return dot(way, axis) * axis + dot(way, out) * next;
}

}  // namespace

SurfacePoint walk(const Surface& scan, const SurfacePoint& start, Point way) {
  SurfacePoint at = start;
  for (int crossed = 0; crossed < kMostFaces; ++crossed) {
    const auto change = weights_along(scan, at.face, way);
    double part = 1;
    int side = -1;
    for (int i = 0; i < 3; ++i) {
      const auto corner = static_cast<std::size_t>(i);
      if (change[corner] >= 0 || at.weights[corner] + change[corner] >= 0) continue;
      const double until = std::max(0.0, at.weights[corner] / -change[corner]);
      if (until < part || side < 0) {
        part = until;
        side = i;
      }
    }
    for (std::size_t i = 0; i < 3; ++i)
      at.weights[i] = std::max(0.0, at.weights[i] + part * change[i]);
    const double sum = at.weights[0] + at.weights[1] + at.weights[2];
    for (double& weight : at.weights) weight /= sum;
    if (side < 0) return at;
    const FaceSide beyond = scan.across[FaceSide(at.face, side).code];
    if (!beyond.exists()) return at;
    const Point along = scan.corner(at.face, (side + 2) % 3) - scan.corner(at.face, (side + 1) % 3);
    way = turned((1 - part) * way, along, face_normal(scan, at.face),
                 face_normal(scan, beyond.face()));
    // The edge has its ends in the other order in the other face.
    SurfacePoint next{beyond.face(), {}};
    next.weights[static_cast<std::size_t>((beyond.side() + 1) % 3)] =
        at.weights[static_cast<std::size_t>((side + 2) % 3)];
    next.weights[static_cast<std::size_t>((beyond.side() + 2) % 3)] =
        at.weights[static_cast<std::size_t>((side + 1) % 3)];
    at = next;
  }
  return at;
}

PLAIT_END_NAMESPACE
