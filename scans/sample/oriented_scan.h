// sample/oriented_scan.h: points of a scan with the normals there.
#pragma once

#include <cmath>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A point of the scan and the scan's normal there.
struct OrientedPoint {
  Point position{}, normal{};
};

/// A scan with a normal at each vertex: that of the faces around it, weighted by area. `scan` must
/// outlive this object. Threads: any number. Memory: 48 bytes a vertex.
class OrientedScan {
 public:
  explicit OrientedScan(const Surface& scan) : scan_(scan) {
    vertices_.reserve(scan.positions.size());
    for (const Point& position : scan.positions) vertices_.push_back({position, {0, 0, 0}});
    for (const auto& face : scan.faces) {
      const auto& [a, b, c] = face;
      const Point normal = area_vector(scan.positions[a], scan.positions[b], scan.positions[c]);
      for (const VertexId vertex : face)
        vertices_[vertex].normal = vertices_[vertex].normal + normal;
    }
    for (OrientedPoint& vertex : vertices_) vertex.normal = normalized(vertex.normal);
  }

  const Surface& surface() const { return scan_; }
  OrientedPoint at(const SurfacePoint& point) const {
    const auto& face = scan_.faces[point.face];
    const OrientedPoint &a = vertices_[face[0]], &b = vertices_[face[1]], &c = vertices_[face[2]];
    const auto& [u, v, w] = point.weights;
    const Point normal = u * a.normal + v * b.normal + w * c.normal;
    const double squared = squared_length(normal);
    return {u * a.position + v * b.position + w * c.position,
            (squared > 0 ? 1 / std::sqrt(squared) : 1) * normal};
  }

 private:
  const Surface& scan_;
  std::vector<OrientedPoint> vertices_;  // both parts of a vertex in one place: at() is hot
};

PLAIT_END_NAMESPACE
