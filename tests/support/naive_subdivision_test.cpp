// Tests of the oracle itself. They compare it with numbers computed by hand, with published masks,
// and with properties that the schemes must have (reproduction of polynomials, convergence to their
// limits), but never with the library.
#include "support/naive_subdivision.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/naive_limit.h"
#include "support/test_meshes.h"

using namespace plait;
using naive::Index;
using naive::Mesh;
using naive::Point;

namespace {

double distance(Point a, Point b) { return naive::length(a - b); }

/// The weight of vertex `source` in the stencil of `vertex`: the position of `vertex` after one
/// step, if only `source` is at height 1. The mesh's own positions are not used.
double weight(Mesh mesh, naive::Scheme scheme, Index source, Index vertex) {
  for (Point& p : mesh.points) p = {};
  mesh.points[source].z = 1;
  return naive::subdivide(mesh, scheme, 1).points[vertex].z;
}

/// The vertex that one step puts on the edge between two vertices of `mesh`.
Index odd_vertex(const Mesh& mesh, Index a, Index b) {
  const Mesh fine = naive::subdivide_midpoint(mesh);
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [p, q, r] = mesh.triangles[t];
    if ((p == a && q == b) || (p == b && q == a)) return naive::vertex_at(fine, t, 1, 0);
    if ((q == a && r == b) || (q == b && r == a)) return naive::vertex_at(fine, t, 1, 1);
    if ((r == a && p == b) || (r == b && p == a)) return naive::vertex_at(fine, t, 0, 1);
  }
  throw std::logic_error("no such edge");
}

}  // namespace

TEST_CASE("NaiveSubdivide_AllMeshes_CountsFollowTheClosedForms") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    Mesh mesh = test::to_naive(indexed);
    std::size_t faces = mesh.triangles.size(), vertices = mesh.points.size();
    std::size_t edges = naive::subdivide_midpoint(mesh).points.size() - vertices;
    for (int level = 1; level <= 3; ++level) {
      mesh = naive::subdivide_loop(mesh);
      vertices += edges;
      edges = 2 * edges + 3 * faces;
      faces *= 4;
      REQUIRE(mesh.level == level);
      REQUIRE(mesh.points.size() == vertices);
      REQUIRE(mesh.triangles.size() == faces);
      REQUIRE(naive::subdivide_midpoint(mesh).points.size() == vertices + edges);
    }
  }
}

TEST_CASE("NaiveMidpoint_LatticePoint_IsTheBarycentricCombinationOfTheCorners") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const Mesh base = test::to_naive(indexed);
    for (const int level : {0, 1, 4}) {
      const Mesh fine = naive::subdivide(base, naive::Scheme::kMidpoint, level);
      const std::int64_t size = std::int64_t{1} << level;
      for (Index t = 0; t < base.triangles.size(); ++t) {
        const auto& [a, b, c] = base.triangles[t];
        const std::vector<Index> patch = naive::patch_vertices(fine, t);
        std::size_t next = 0;
        for (std::int64_t j = 0; j <= size; ++j) {
          for (std::int64_t i = 0; i <= size - j; ++i) {
            const double u = static_cast<double>(i) / static_cast<double>(size);
            const double v = static_cast<double>(j) / static_cast<double>(size);
            const Point expected =
                (1 - u - v) * base.points[a] + u * base.points[b] + v * base.points[c];
            REQUIRE(distance(fine.points[patch[next++]], expected) < 1e-14);
          }
        }
        REQUIRE(next == patch.size());
        REQUIRE(naive::vertex_at(fine, t, 0, 0) == a);
        REQUIRE(naive::vertex_at(fine, t, size, 0) == b);
        REQUIRE(naive::vertex_at(fine, t, 0, size) == c);
      }
    }
  }
}

TEST_CASE("NaiveLoop_Octahedron_HasThePositionsWorkedOutByHand") {
  const Mesh base = test::to_naive(test::octahedron());
  const Mesh fine = naive::subdivide_loop(base);
  // The neighbours of a vertex cancel out, and so do the two wings of an edge. For valence 4, n
  // beta is 31/64.
  for (Index v = 0; v < 6; ++v) CHECK(distance(fine.points[v], 33.0 / 64 * base.points[v]) < 1e-15);
  const Point odd = fine.points[odd_vertex(base, 0, 2)];
  CHECK(distance(odd, {0.375, 0.375, 0}) < 1e-15);
}

TEST_CASE("NaiveLoop_EvenInterior_HasLoopsWeights") {
  CHECK(naive::loop_beta(3) == Approx(3.0 / 16).epsilon(1e-14));
  CHECK(naive::loop_beta(4) == Approx(31.0 / 256).epsilon(1e-14));
  CHECK(naive::loop_beta(6) == Approx(1.0 / 16).epsilon(1e-14));
  for (const Index n : {3u, 4u, 5u, 6u, 7u, 12u, 26u}) {
    const Mesh fan = test::to_naive(test::closed_fan(n));
    // Valence 5 uses the closed form cos(72 degrees) = (sqrt(5)-1)/4, valence 7 the standard
    // library's cosine.
    const double root = 0.375 + 0.25 * (n == 5 ? (std::sqrt(5.0) - 1) / 4
                                               : std::cos(2 * std::acos(-1.0) / double(n)));
    const double ring_weight = (0.625 - root * root) / n;
    CHECK(weight(fan, naive::Scheme::kLoop, 0, 0) == Approx(1 - n * ring_weight).epsilon(1e-13));
    for (Index k = 1; k <= n; ++k)
      CHECK(weight(fan, naive::Scheme::kLoop, k, 0) == Approx(ring_weight).epsilon(1e-13));
  }
}

TEST_CASE("NaiveLoop_Odd_HasThreeEighthsAndOneEighth") {
  const Mesh mesh = test::to_naive(test::two_triangles());
  const Index odd = odd_vertex(mesh, 0, 2);
  CHECK(weight(mesh, naive::Scheme::kLoop, 0, odd) == 3.0 / 8);
  CHECK(weight(mesh, naive::Scheme::kLoop, 2, odd) == 3.0 / 8);
  CHECK(weight(mesh, naive::Scheme::kLoop, 1, odd) == 1.0 / 8);
  CHECK(weight(mesh, naive::Scheme::kLoop, 3, odd) == 1.0 / 8);
}

TEST_CASE("NaiveLoop_Border_FollowsTheCubicSplineOfTheBorderAlone") {
  const Mesh fan = test::to_naive(test::open_fan(5));  // vertex 0 between neighbours 1 and 6
  CHECK(weight(fan, naive::Scheme::kLoop, 0, 0) == 3.0 / 4);
  for (Index k = 1; k <= 6; ++k)
    CHECK(weight(fan, naive::Scheme::kLoop, k, 0) == (k == 1 || k == 6 ? 1.0 / 8 : 0.0));
  const Index odd = odd_vertex(fan, 0, 1);
  for (Index k = 0; k <= 6; ++k)
    CHECK(weight(fan, naive::Scheme::kLoop, k, odd) == (k <= 1 ? 0.5 : 0.0));
}

TEST_CASE("NaiveSubdivide_LinearHeights_AreReproducedOnAPlanarSheet") {
  Mesh mesh = test::to_naive(test::sheet(6, 5));
  for (Point& p : mesh.points) p.z = 2 * p.x - 3 * p.y + 1;
  for (const auto scheme : {naive::Scheme::kButterfly, naive::Scheme::kMidpoint}) {
    const Mesh fine = naive::subdivide(mesh, scheme, 2);
    for (const Point& p : fine.points) REQUIRE(p.z == Approx(2 * p.x - 3 * p.y + 1).margin(1e-12));
  }
  // Loop moves the border along itself, never out of the plane.
  for (const Point& p : naive::subdivide(mesh, naive::Scheme::kLoop, 2).points)
    REQUIRE(p.z == Approx(2 * p.x - 3 * p.y + 1).margin(1e-12));
}

TEST_CASE("NaiveButterfly_CubicHeights_AreReproducedInsideARegularSheet") {
  const auto height = [](double x, double y) {
    return x * x * x - 2 * x * x * y + 0.5 * y * y * y + x * y + 3;
  };
  Mesh mesh = test::to_naive(test::sheet(8, 8));
  for (Point& p : mesh.points) p.z = height(p.x, p.y);
  const Mesh fine = naive::subdivide_butterfly(mesh);
  int checked = 0;
  for (const Point& p : fine.points) {
    if (p.x < 2 || p.x > 6 || p.y < 2 || p.y > 6) continue;
    REQUIRE(p.z == Approx(height(p.x, p.y)).margin(1e-10));
    ++checked;
  }
  REQUIRE(checked == 9 * 9);
}

TEST_CASE("NaiveButterfly_RegularEdge_HasTheEightPointStencil") {
  const Mesh mesh = test::to_naive(test::sheet(5, 5));
  const auto at = [](Index column, Index row) { return column + 6 * row; };
  const Index odd = odd_vertex(mesh, at(2, 2), at(3, 2));
  double total = 0;
  for (Index source = 0; source < mesh.points.size(); ++source) {
    const double found = weight(mesh, naive::Scheme::kButterfly, source, odd);
    double expected = 0;
    if (source == at(2, 2) || source == at(3, 2)) expected = 0.5;
    if (source == at(3, 3) || source == at(2, 1)) expected = 0.125;
    if (source == at(2, 3) || source == at(4, 3) || source == at(1, 1) || source == at(3, 1))
      expected = -0.0625;
    CHECK(found == expected);
    total += found;
  }
  CHECK(total == 1);
}

TEST_CASE("NaiveButterfly_MissingWings_AreContinuedInThePlaneOfTheTriangle") {
  // All four wings are missing: 1/2 (A+B) + 1/8 (C+D) - 1/16 (2C + 2D) gives the middle of the
  // edge.
  const Mesh mesh = test::to_naive(test::two_triangles());
  const Index odd = odd_vertex(mesh, 0, 2);
  const Mesh fine = naive::subdivide_butterfly(mesh);
  CHECK(distance(fine.points[odd], 0.5 * (mesh.points[0] + mesh.points[2])) < 1e-15);

  // Only one wing exists: at the spoke 0-2 of an open fan of three triangles, both ends are on the
  // border, the wings across (0,1), (1,2) and (2,3) are missing, and vertex 4 is the wing across
  // (0,3).
  const Mesh fan = test::to_naive(test::open_fan(3));
  const double expected[] = {0.5 - (1 - 1 - 1) / 16.0, 0.125 - (1 + 1) / 16.0,
                             0.5 - (-1 + 1 + 1) / 16.0, 0.125 - 1 / 16.0, -1 / 16.0};
  for (Index source = 0; source < 5; ++source)
    CHECK(weight(fan, naive::Scheme::kButterfly, source, odd_vertex(fan, 0, 2)) ==
          expected[source]);
}

TEST_CASE("NaiveButterfly_BorderEdge_HasTheFourPointStencil") {
  const Mesh mesh = test::to_naive(test::sheet(4, 2));
  const Index odd = odd_vertex(mesh, 1, 2);
  const double expected[] = {-1.0 / 16, 9.0 / 16, 9.0 / 16, -1.0 / 16};
  for (Index source = 0; source < mesh.points.size(); ++source)
    CHECK(weight(mesh, naive::Scheme::kButterfly, source, odd) ==
          (source < 4 ? expected[source] : 0.0));
}

TEST_CASE("NaiveButterfly_IrregularEnd_HasZorinsWeightsFromTheOtherEnd") {
  // The ring of a closed fan is on the border, so its vertices count as regular.
  const auto check = [](Index n, const std::vector<double>& expected) {
    const Mesh fan = test::to_naive(test::closed_fan(n));
    for (Index spoke = 1; spoke <= n; ++spoke) {
      const Index odd = odd_vertex(fan, 0, spoke);
      CHECK(weight(fan, naive::Scheme::kButterfly, 0, odd) == Approx(0.75));
      for (Index j = 0; j < n; ++j)
        CHECK(weight(fan, naive::Scheme::kButterfly, 1 + (spoke - 1 + j) % n, odd) ==
              Approx(expected[j]).margin(1e-15));
    }
  };
  check(3, {5.0 / 12, -1.0 / 12, -1.0 / 12});
  check(4, {3.0 / 8, 0, -1.0 / 8, 0});
  const double root5 = std::sqrt(5.0);  // cos 72 = (root5-1)/4, cos 144 = -(root5+1)/4
  const double near = (0.25 + (root5 - 1) / 4 - (root5 + 1) / 8) / 5;
  const double far = (0.25 - (root5 + 1) / 4 + (root5 - 1) / 8) / 5;
  check(5, {0.35, near, far, far, near});
  check(8, {0.21875, (0.25 + std::sqrt(0.5)) / 8, -0.03125, (0.25 - std::sqrt(0.5)) / 8, -0.03125,
            (0.25 - std::sqrt(0.5)) / 8, -0.03125, (0.25 + std::sqrt(0.5)) / 8});
}

TEST_CASE("NaiveButterfly_BothEndsIrregular_TakesTheMeanOfBoth") {
  // Tetrahedron, edge 0-1: end 0 gives the weights 3/4 to 0, 5/12 to 1, and -1/12 to 2 and 3; end 1
  // gives them likewise.
  const Mesh mesh = test::to_naive(test::tetrahedron());
  const Index odd = odd_vertex(mesh, 0, 1);
  const double end = 0.5 * (3.0 / 4 + 5.0 / 12), wing = -1.0 / 12;
  const double expected[] = {end, end, wing, wing};
  for (Index source = 0; source < 4; ++source)
    CHECK(weight(mesh, naive::Scheme::kButterfly, source, odd) == Approx(expected[source]));
}

TEST_CASE("NaiveButterfly_AllMeshes_InterpolatesAndItsWeightsSumToOne") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    Mesh mesh = test::to_naive(indexed);
    const Mesh fine = naive::subdivide_butterfly(mesh);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) REQUIRE(fine.points[v] == mesh.points[v]);
    for (Point& p : mesh.points) p = {1, 1, 1};
    for (const auto scheme : {naive::Scheme::kButterfly, naive::Scheme::kLoop})
      for (const Point& p : naive::subdivide(mesh, scheme, 1).points)
        REQUIRE(distance(p, {1, 1, 1}) < 1e-14);
  }
}

TEST_CASE("Rings_Find_IsCounterclockwiseAndClosedOnlyInside") {
  const Mesh inside = test::to_naive(test::closed_fan(5));
  CHECK(naive::Rings(inside).find(0).neighbours == std::vector<Index>{1, 2, 3, 4, 5});
  CHECK(naive::Rings(inside).find(0).closed);
  CHECK(naive::Rings(inside).find(3).neighbours == std::vector<Index>{4, 0, 2});
  CHECK_FALSE(naive::Rings(inside).find(3).closed);
  const Mesh open = test::to_naive(test::open_fan(3));
  CHECK(naive::Rings(open).find(0).neighbours == std::vector<Index>{1, 2, 3, 4});
  CHECK_FALSE(naive::Rings(open).find(0).closed);
}

TEST_CASE("TestMeshes_ClosedOnes_AreOrientedOutwardAndRandomOnesHaveManyValences") {
  for (const auto& [name, indexed] : test::closed_meshes()) {
    if (name == "seven_vertex_torus") continue;  // it crosses itself, so it has no outside
    INFO(name);
    const Mesh mesh = test::to_naive(indexed);
    double volume = 0;
    for (const auto& [a, b, c] : mesh.triangles)
      volume += naive::dot(mesh.points[a], naive::cross(mesh.points[b], mesh.points[c])) / 6;
    CHECK(volume > 0.3);
  }
  const Mesh random = test::to_naive(test::random_sheet(1, 60));
  std::size_t least = 99, most = 0;
  for (Index v = 0; v < random.points.size(); ++v) {
    const std::size_t valence = naive::Rings(random).find(v).neighbours.size();
    least = std::min(least, valence);
    most = std::max(most, valence);
  }
  CHECK(least == 2);
  CHECK(most >= 9);
}

TEST_CASE("NaiveSubdivide_NotAManifold_IsRefused") {
  struct Bad {
    std::size_t points;
    std::vector<naive::Triangle> triangles;
    std::string reason;
  };
  const Bad all[] = {
      {4, {{0, 1, 2}, {0, 1, 3}}, "orientations disagree"},
      {5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, "more than two triangles"},
      {5, {{0, 1, 2}, {0, 3, 4}}, "vertex on two borders"},
      {3, {{0, 1, 3}}, "out of range"},
      {3, {{0, 1, 1}}, "degenerate"},
      {4, {{0, 1, 2}}, "without triangles"},
  };
  for (const auto& [points, triangles, reason] : all) {
    const Mesh mesh{std::vector<Point>(points), triangles, 0};
    CHECK_THROWS_WITH(naive::subdivide_loop(mesh), Catch::Contains(reason));
    CHECK_THROWS_WITH(naive::subdivide_butterfly(mesh), Catch::Contains(reason));
  }
  // Two tetrahedra that share vertex 0.
  Mesh bowtie = test::to_naive(test::tetrahedron());
  bowtie.points.resize(7);
  for (const auto& [a, b, c] : std::vector<naive::Triangle>(bowtie.triangles))
    bowtie.triangles.push_back({a == 0 ? 0 : a + 3, b == 0 ? 0 : b + 3, c == 0 ? 0 : c + 3});
  CHECK_THROWS_WITH(naive::Rings(bowtie).find(0), Catch::Contains("several fans"));
}
