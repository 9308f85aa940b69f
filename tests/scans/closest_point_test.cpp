#include "distance/closest_point.h"

#include <catch2/catch.hpp>
#include <random>

#include "support/test_meshes.h"

namespace plait::test {
namespace {

/// The smallest squared distance to points of a fine grid on the triangle: never smaller than the
/// true one, and larger by at most about a step of the grid.
double least_of_grid(Point p, Point a, Point b, Point c, int size) {
  double least = 1e300;
  for (int i = 0; i <= size; ++i)
    for (int j = 0; i + j <= size; ++j) {
      const double u = static_cast<double>(i) / size, v = static_cast<double>(j) / size;
      least = std::min(least, squared_length(a + u * (b - a) + v * (c - a) - p));
    }
  return least;
}

}  // namespace

TEST_CASE("ClosestOfTriangle_RandomPoints_IsNoFartherThanAnyPointOfGrid") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Point{number(random), number(random), number(random)}; };
  for (int round = 0; round < 300; ++round) {
    const Point a = point(), b = point(), c = point(), p = 2.0 * point();
    const double found = length(closest_of_triangle(p, a, b, c) - p);
    const double grid = std::sqrt(least_of_grid(p, a, b, c, 60));
    CHECK(found <= grid + 1e-12);
    CHECK(found >= grid - 3.5 / 60);
  }
}

TEST_CASE("TriangleTree_EveryMeshNearAndFar_FindsWhatBruteForceFinds") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-3, 3);
  for (const NamedMesh& named : all_meshes()) {
    for (const Point& origin : {Point{}, Point{5e6, -5e6, 100}}) {
      CAPTURE(named.name, origin.x);
      IndexedMesh mesh = named.mesh;
      for (Point& p : mesh.positions) p = p + origin;
      const TriangleTree tree(mesh.positions, mesh.faces);
      double worst = 0;
      for (int round = 0; round < 50; ++round) {
        const Point p = origin + Point{number(random), number(random), number(random)};
        double least = 1e300;
        for (const auto& [a, b, c] : mesh.faces)
          least = std::min(
              least, squared_length(closest_of_triangle(p, mesh.positions[a], mesh.positions[b],
                                                        mesh.positions[c]) -
                                    p));
        const auto hint = static_cast<FaceId>(static_cast<std::size_t>(round) % mesh.faces.size());
        worst = std::max(worst, std::abs(tree.closest(p, hint).squared_distance - least));
      }
      CHECK(worst == 0);
    }
  }
}

}  // namespace plait::test
