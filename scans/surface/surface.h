// surface/surface.h: a triangle mesh in memory that knows the face across each side: an oriented
// 2-manifold, with or without border. Scans are such meshes once they are repaired (repair.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

using Point = Vector3<double>;

struct Surface {
  std::vector<Point> positions;
  std::vector<std::array<VertexId, 3>> faces;
  /// [3 face + side]: the same edge as a side of the other face; it does not exist at a border.
  std::vector<FaceSide> across;

  Point corner(FaceId face, int corner) const {
    return positions[faces[face][static_cast<std::size_t>(corner)]];
  }
};

/// A point of a surface: a face, and barycentric coordinates at its corners, whose sum is 1.
struct SurfacePoint {
  FaceId face = kNoId;
  std::array<double, 3> weights{};
};

inline Point position_of(const Surface& surface, const SurfacePoint& at) {
  const auto& [a, b, c] = surface.faces[at.face];
  return at.weights[0] * surface.positions[a] + at.weights[1] * surface.positions[b] +
         at.weights[2] * surface.positions[c];
}

inline double squared_length(Point a) { return dot(a, a); }
inline double length(Point a) { return std::sqrt(dot(a, a)); }

/// Twice the area of the triangle, as a vector along its normal.
inline Point area_vector(Point a, Point b, Point c) { return cross(b - a, c - a); }

/// Of length 1.
inline Point face_normal(const Surface& surface, FaceId face) {
  return normalized(
      area_vector(surface.corner(face, 0), surface.corner(face, 1), surface.corner(face, 2)));
}

/// 1 for an equilateral triangle, 0 for one without area: area over the sum of the squared sides,
/// scaled (R. Bank and R. Smith, "Mesh smoothing using a posteriori error estimates", 1997).
/// `twice_area` has the sign of the result.
inline double triangle_quality(double twice_area, double squared_sides) {
  constexpr double kEquilateral = 3.4641016151377544;  // 2 sqrt(3)
  return squared_sides > 0 ? kEquilateral * twice_area / squared_sides : 0;
}

PLAIT_END_NAMESPACE
