#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "generate/kinds.h"
#include "generate/random.h"
#include "generate/reduce.h"
#include "generate/smoothing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

constexpr std::array<std::array<VertexId, 3>, 20> kIcosahedronFaces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

std::array<Vector3<double>, 12> icosahedron_corners() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  return {{{-1, g, 0},
           {1, g, 0},
           {-1, -g, 0},
           {1, -g, 0},
           {0, -1, g},
           {0, 1, g},
           {0, -1, -g},
           {0, 1, -g},
           {g, 0, -1},
           {g, 0, 1},
           {-g, 0, -1},
           {-g, 0, 1}}};
}

/// Three unit vectors at right angles: the axes of a sphere, rotated at random by the seed.
std::array<Vector3<double>, 3> random_axes(std::uint64_t seed) {
  Random random(seed);
  const Vector3<double> x = random.direction();
  Vector3<double> y = random.direction();
  while (dot(cross(x, y), cross(x, y)) < 0.1) y = random.direction();
  const Vector3<double> z = normalized(cross(x, y));
  return {x, cross(z, x), z};
}

/// The icosahedron with every edge divided into `frequency` parts and every vertex on the unit
/// sphere.
class GeodesicSphere {
 public:
  GeodesicSphere(std::uint64_t frequency, const std::array<Vector3<double>, 3>& axes)
      : frequency_(frequency), axes_(axes) {
    for (const Vector3<double>& corner : icosahedron_corners()) add_vertex(corner);
    for (const auto& face : kIcosahedronFaces) add_face(face);
  }
  IndexedMesh take() && { return std::move(mesh_); }

 private:
  VertexId add_vertex(Vector3<double> place) {
    mesh_.positions.push_back(
        normalized(place.x * axes_[0] + place.y * axes_[1] + place.z * axes_[2]));
    return static_cast<VertexId>(mesh_.positions.size() - 1);
  }

  /// The vertices inside the edge from `a` to `b`. The first call for an edge makes them.
  const std::vector<VertexId>& edge_points(VertexId a, VertexId b) {
    std::vector<VertexId>& forward = edge_points_[a * 12 + b];
    std::vector<VertexId>& backward = edge_points_[b * 12 + a];
    if (forward.empty() && frequency_ > 1) {
      for (std::uint64_t step = 1; step < frequency_; ++step)
        forward.push_back(add_vertex(blend(a, b, a, frequency_ - step, step, 0)));
      backward.assign(forward.rbegin(), forward.rend());
    }
    return forward;
  }

  Vector3<double> blend(VertexId a, VertexId b, VertexId c, std::uint64_t weight_a,
                        std::uint64_t weight_b, std::uint64_t weight_c) const {
    return static_cast<double>(weight_a) * corners_[a] +
           static_cast<double>(weight_b) * corners_[b] +
           static_cast<double>(weight_c) * corners_[c];
  }

  void add_face(const std::array<VertexId, 3>& face) {
    const auto& [a, b, c] = face;
    const std::vector<VertexId>& left = edge_points(a, c);
    const std::vector<VertexId>& right = edge_points(b, c);
    const std::vector<VertexId>& bottom = edge_points(a, b);
    // Row by row from the edge ab to the corner c.
    std::vector<VertexId> row{a}, next_row;
    row.insert(row.end(), bottom.begin(), bottom.end());
    row.push_back(b);
    for (std::uint64_t height = 1; height <= frequency_; ++height) {
      next_row.clear();
      if (height == frequency_) {
        next_row.push_back(c);
      } else {
        next_row.push_back(left[height - 1]);
        for (std::uint64_t step = 1; step + height < frequency_; ++step)
          next_row.push_back(add_vertex(blend(a, b, c, frequency_ - height - step, step, height)));
        next_row.push_back(right[height - 1]);
      }
      for (std::size_t i = 0; i < next_row.size(); ++i) {
        mesh_.faces.push_back({row[i], row[i + 1], next_row[i]});
        if (i + 1 < next_row.size())
          mesh_.faces.push_back({next_row[i], row[i + 1], next_row[i + 1]});
      }
      row.swap(next_row);
    }
  }

  std::uint64_t frequency_;
  std::array<Vector3<double>, 3> axes_;
  std::array<Vector3<double>, 12> corners_ = icosahedron_corners();
  std::array<std::vector<VertexId>, 144> edge_points_;
  IndexedMesh mesh_;
};

}  // namespace

IndexedMesh make_icosphere(std::uint64_t vertices, std::uint64_t seed, const Progress& progress) {
  std::uint64_t frequency = 1;
  while (10 * frequency * frequency + 2 < vertices) ++frequency;
  IndexedMesh sphere = GeodesicSphere(frequency, random_axes(seed)).take();
  progress(0.2);
  if (sphere.positions.size() > vertices) {
    constexpr double kRandomness = 3;
    sphere = reduce(std::move(sphere), {vertices, seed, kRandomness}, progress.part(0.2, 0.9));
    constexpr int kSmoothingSteps = 2;
    for (int step = 0; step < kSmoothingSteps; ++step) {
      smooth(sphere, 0.5);
      for (Vector3<double>& position : sphere.positions) position = normalized(position);
    }
  }
  return sphere;
}

}  // namespace generation
PLAIT_END_NAMESPACE
