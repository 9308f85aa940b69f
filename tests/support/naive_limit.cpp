#include "support/naive_limit.h"

#include <cmath>
#include <numbers>

namespace plait::naive {
namespace {

Point limit_normal(const Mesh& mesh, Index vertex, const Ring& ring) {
  // Uses differences to the vertex, so that rounding of the weights has no effect on the position.
  const Point centre = mesh.points[vertex];
  const auto spoke = [&](std::size_t k) { return mesh.points[ring.neighbours[k]] - centre; };
  const std::size_t n = ring.neighbours.size();
  Point first, second;
  if (ring.closed) {
    for (std::size_t k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
      first += std::cos(angle) * spoke(k);
      second += std::sin(angle) * spoke(k);
    }
  } else {
    first = spoke(0) - spoke(n - 1);
    const std::vector<double> weights = border_tangent_weights(n);
    for (std::size_t k = 0; k < n; ++k) second += weights[k + 1] * spoke(k);
  }
  return unit(cross(first, second));
}

}  // namespace

std::vector<double> border_tangent_weights(std::size_t k) {
  if (k == 2) return {-2, 1, 1};
  const double theta = std::numbers::pi / static_cast<double>(k - 1);
  const double lambda = 3.0 / 8 + std::cos(theta) / 4;
  std::vector<double> weights(k + 1);
  double sum = 0;
  for (std::size_t i = 2; i < k; ++i) {
    weights[i] = std::sin(static_cast<double>(i - 1) * theta);
    sum += weights[i];
  }
  const double centre =
      (3.0 / 8 * (lambda - 0.5) * sum + weights[2] / 8) / ((lambda - 1) * (lambda - 0.25));
  weights[0] = centre;
  weights[1] = weights[k] = centre * (lambda - 0.75) - 3.0 / 8 * sum;
  return weights;
}

std::vector<Point> loop_limit_points(const Mesh& mesh) {
  const Rings rings(mesh);
  Ring ring;
  std::vector<Point> limits;
  limits.reserve(mesh.points.size());
  for (Index v = 0; v < mesh.points.size(); ++v) {
    rings.find(v, ring);
    const std::size_t n = ring.neighbours.size();
    Point sum;
    if (ring.closed) {
      for (const Index neighbour : ring.neighbours) sum += mesh.points[neighbour];
      const double omega = 1 / (static_cast<double>(n) + 3 / (8 * loop_beta(n)));
      limits.push_back((1 - static_cast<double>(n) * omega) * mesh.points[v] + omega * sum);
    } else {
      sum = mesh.points[ring.neighbours.front()] + mesh.points[ring.neighbours.back()];
      limits.push_back(2.0 / 3 * mesh.points[v] + 1.0 / 6 * sum);
    }
  }
  return limits;
}

std::vector<Point> loop_limit_normals(const Mesh& mesh) {
  const Rings rings(mesh);
  Ring ring;
  std::vector<Point> normals;
  normals.reserve(mesh.points.size());
  for (Index v = 0; v < mesh.points.size(); ++v) {
    rings.find(v, ring);
    normals.push_back(limit_normal(mesh, v, ring));
  }
  return normals;
}

std::vector<Point> area_weighted_normals(const Mesh& mesh) {
  std::vector<Point> normals(mesh.points.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point twice_area =
        cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
    for (const Index vertex : {a, b, c}) normals[vertex] += twice_area;
  }
  for (Point& normal : normals) normal = unit(normal);
  return normals;
}

double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Point cross(Point a, Point b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double length(Point a) { return std::sqrt(dot(a, a)); }

Point unit(Point a) {
  const double size = length(a);
  return size > 0 ? 1 / size * a : a;
}

double angle_between(Point a, Point b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

}  // namespace plait::naive
