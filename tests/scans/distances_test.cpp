#include "distance/distances.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "distance/closest_point.h"
#include "plait/error.h"
#include "support/error_of.h"
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

namespace {

/// The square from 0 to `side` in x and y at height z, as two triangles.
IndexedMesh square(double side, double z) {
  return {{{0, 0, z}, {side, 0, z}, {side, side, z}, {0, side, z}}, {{0, 1, 2}, {0, 2, 3}}};
}

Distances distances(const IndexedMesh& from, const IndexedMesh& to) {
  const TriangleTree tree(to.positions, to.faces);
  return measure_distances({from.positions, from.faces}, tree, {to.positions, to.faces},
                           {.samples = 100000});
}

}  // namespace

TEST_CASE("Distances_ParallelSquares_AreTheirGap", "[threads]") {
  const Distances found = distances(square(2, 0), square(2, 0.25));
  CHECK(found.samples == 100000);
  for (const double value : {found.max, found.rms, found.mean, found.percentile_99})
    CHECK(value == Approx(0.25));
  CHECK(found.mean_angle == Approx(0).margin(1e-6));
}

TEST_CASE("Distances_Progress_IsToldOftenAndCancelsAtOnce", "[threads]") {
  // Far from each other: then each search looks at many faces.
  const IndexedMesh here = square(1, 0), far = square(2, 1000);
  const TriangleTree tree(far.positions, far.faces);
  std::vector<std::uint64_t> told;
  DistanceOptions options{.samples = 200000};
  options.progress = [&](const Progress& now) {
    told.push_back(now.done);
    return true;
  };
  measure_distances({here.positions, here.faces}, tree, {far.positions, far.faces}, options);
  REQUIRE(told.size() >= 200000 / 32768);
  for (std::size_t i = 1; i < told.size(); ++i) CHECK(told[i] - told[i - 1] <= 32768);
  options.progress = [&](const Progress& now) { return now.done < 10000; };
  CHECK(
      error_of([&] {
        measure_distances({here.positions, here.faces}, tree, {far.positions, far.faces}, options);
      }).code() == ErrorCode::kCancelled);
}

TEST_CASE("Distances_FarSamples_AreOfTheirPlaces", "[threads]") {
  // Two squares above a large one, another size and height each, and one that is on it.
  IndexedMesh from;
  const auto add = [&](double side, double x, double z) {
    const auto first = static_cast<VertexId>(from.positions.size());
    for (const Point& p : square(side, z).positions) from.positions.push_back({p.x + x, p.y, p.z});
    for (const auto& [a, b, c] : square(side, z).faces)
      from.faces.push_back({a + first, b + first, c + first});
  };
  add(1, 0, 10);
  add(2, 50, 5);
  add(3, 80, 0);
  const IndexedMesh to = square(200, 0);
  const Distances found =
      measure_distances({from.positions, from.faces}, TriangleTree(to.positions, to.faces),
                        {to.positions, to.faces}, {.samples = 14000, .far = 3});
  CHECK(found.far_share == Approx(5.0 / 14).epsilon(0.01));
  REQUIRE(found.far_places.size() == 2);
  CHECK(found.far_places[0].distance == Approx(10));
  CHECK(found.far_places[0].share == Approx(1.0 / 14).epsilon(0.01));
  CHECK(found.far_places[1].distance == Approx(5));
  CHECK(found.far_places[1].share == Approx(4.0 / 14).epsilon(0.01));
  for (std::size_t place = 0; place < 2; ++place) {
    const Point at = found.far_places[place].at;
    CHECK(at.z == Approx(place == 0 ? 10 : 5));
    CHECK(at.x >= (place == 0 ? 0 : 50));
    CHECK(at.x <= (place == 0 ? 1 : 52));
  }
  CHECK(distances(from, to).far_places.empty());
}

TEST_CASE("TriangleTree_ManyFaces_CanBeCancelledWhileItIsBuilt") {
  IndexedMesh mesh;
  for (int i = 0; i < 30000; ++i)
    for (const Point& p : {Point{i * 1.0, 0, 0}, Point{i + 0.5, 0, 0}, Point{i * 1.0, 1, 0}})
      mesh.positions.push_back(p);
  for (VertexId i = 0; i < 30000; ++i) mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  int calls = 0;
  const TriangleTree tree(mesh.positions, mesh.faces, [&] { ++calls; });
  CHECK(calls == 3);  // the whole and its halves
  CHECK_THROWS_AS(TriangleTree(mesh.positions, mesh.faces, [] { throw 1; }), int);
}

TEST_CASE("Distances_LargerSquare_DifferByDirection") {
  // Beyond the small square, up to 1 in x and in y. Integrals: of the squared distance to the unit
  // square over the rest of the square of side 2, 2 (1/3) + 2/3; of the distance, 2 (1/2) + the
  // mean length of a vector in the unit square, 0.76519572.
  const Distances found = distances(square(2, 0), square(1, 0));
  CHECK(found.max == Approx(std::sqrt(2.0)).margin(0.01));
  CHECK(found.rms == Approx(std::sqrt((4.0 / 3) / 4)).epsilon(0.005));
  CHECK(found.mean == Approx((1 + 0.76519572) / 4).epsilon(0.005));
  CHECK(distances(square(1, 0), square(2, 0)).max == Approx(0).margin(1e-9));
}

TEST_CASE("Distances_TurnedSurface_GiveTheAngle") {
  IndexedMesh slope = square(1, 0);
  for (Point& p : slope.positions) p.z = p.x;
  CHECK(distances(square(1, 0), slope).mean_angle == Approx(45).margin(1e-3));
}

TEST_CASE("Distances_TrianglesOfUnequalArea_CountByArea") {
  // A tenth of the area is at height 1.
  IndexedMesh mesh = square(3, 0);
  const auto large = static_cast<VertexId>(mesh.positions.size());
  for (const Point& p : square(1, 1).positions) mesh.positions.push_back(p);
  for (const auto& [a, b, c] : square(1, 1).faces)
    mesh.faces.push_back({large + a, large + b, large + c});
  const Distances found = distances(mesh, square(3, 0));
  CHECK(found.mean == Approx(0.1).epsilon(1e-3));
  CHECK(found.rms == Approx(std::sqrt(0.1)).epsilon(1e-3));
}

TEST_CASE("Distances_Slope_GivesThePercentilesOfItsHeights") {
  IndexedMesh slope = square(1, 0);
  for (Point& p : slope.positions) p.z = p.x;
  const Distances found = distances(slope, square(1, 0));
  CHECK(found.percentile_99 == Approx(0.99).margin(2e-4));
  CHECK(found.percentile_99_9 == Approx(0.999).margin(2e-4));
  CHECK(found.max > 0.9995);
}

TEST_CASE("Distances_SmallTurnedPart_IsInThePercentileOfAngles") {
  // A flat square, and beside it a strip of 3 % of the whole area that rises by 45 degrees. Upside
  // down, the angles are those of the other side.
  const double width = 0.03 / 0.97, along = width / std::sqrt(2.0);
  IndexedMesh mesh = square(1, 0);
  mesh.positions.insert(mesh.positions.end(), {{1 + along, 0, along}, {1 + along, 1, along}});
  mesh.faces.insert(mesh.faces.end(), {{1, 4, 5}, {1, 5, 2}});
  const Distances found = distances(mesh, square(2, 0));
  CHECK(found.mean_angle == Approx(0.03 * 45).epsilon(1e-3));
  CHECK(found.percentile_99_angle == Approx(45).margin(1e-3));
  for (auto& face : mesh.faces) std::swap(face[0], face[1]);
  CHECK(distances(mesh, square(2, 0)).mean_angle == Approx(180 - 0.03 * 45).epsilon(1e-3));
}

TEST_CASE("Distances_WithoutArea_AreRefused") {
  IndexedMesh flat = square(1, 0);
  for (Point& p : flat.positions) p.y = 0;
  CHECK(error_of([&] { distances(flat, square(1, 0)); }).code() == ErrorCode::kInvalidArgument);
}

TEST_CASE("Diagonal_UnusedVertex_DoesNotCount") {
  IndexedMesh mesh = square(1, 0);
  mesh.positions.push_back({99, 99, 99});
  CHECK(diagonal_of({mesh.positions, mesh.faces}) == Approx(std::sqrt(2.0)));
  CHECK(mean_edge_of({mesh.positions, mesh.faces}) == Approx((4 + 2 * std::sqrt(2.0)) / 6));
}

}  // namespace plait::test
