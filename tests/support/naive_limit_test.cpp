// Tests of the oracle's masks. They compare the masks with published weights, and with the
// triangles around a vertex after many naive steps.
#include "support/naive_limit.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <vector>

#include "support/test_meshes.h"

using namespace plait;
using naive::Index;
using naive::Mesh;
using naive::Point;

namespace {

double limit_distance(Point a, Point b) { return naive::length(a - b); }

/// The triangles at vertex 0 of a fan that was refined once, again as a fan (vertex 0, then its
/// ring). It is moved and scaled so that rounding errors stay small; subdivision commutes with
/// both.
Mesh zoomed(const Mesh& fine) {
  const naive::Ring ring = naive::Rings(fine).find(0);
  Mesh fan;
  double size = 0;
  for (const Index p : ring.neighbours)
    size = std::max(size, limit_distance(fine.points[p], fine.points[0]));
  fan.points.push_back({});
  for (const Index p : ring.neighbours)
    fan.points.push_back(1 / size * (fine.points[p] - fine.points[0]));
  const auto count = static_cast<Index>(ring.neighbours.size());
  for (Index k = 0; k + (ring.closed ? 0 : 1) < count; ++k)
    fan.triangles.push_back({0, 1 + k, 1 + (k + 1) % count});
  return fan;
}

Mesh zoomed(Mesh fan, int levels) {
  for (int level = 0; level < levels; ++level) fan = zoomed(naive::subdivide_loop(fan));
  return fan;
}

Point triangle_normal(const Mesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return naive::unit(
      naive::cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
}

}  // namespace

TEST_CASE("LoopLimitPoints_FanRefinedForty_ReachTheirMask") {
  const auto check = [](Mesh fan) {
    const Point expected = naive::loop_limit_points(fan)[0];
    for (int level = 0; level < 40; ++level) {
      const Mesh fine = naive::subdivide_loop(fan);
      const naive::Ring ring = naive::Rings(fine).find(0);
      for (Index k = 0; k < ring.neighbours.size(); ++k)
        fan.points[1 + k] = fine.points[ring.neighbours[k]];
      fan.points[0] = fine.points[0];
    }
    CHECK(limit_distance(fan.points[0], expected) < 1e-9);
  };
  for (Index n = 3; n <= 26; ++n) check(test::to_naive(test::closed_fan(n)));
  for (Index n = 1; n <= 12; ++n) check(test::to_naive(test::open_fan(n)));
}

TEST_CASE("LoopLimitNormals_Interior_AreWhatTheTrianglesTurnInto") {
  for (Index n = 3; n <= 12; ++n) {
    INFO("valence " << n);
    const Mesh fan = test::to_naive(test::closed_fan(n));
    const Point expected = naive::loop_limit_normals(fan)[0];
    CHECK(expected.z > 0);
    const Mesh close = zoomed(fan, 60);
    for (std::size_t t = 0; t < close.triangles.size(); ++t)
      CHECK(naive::angle_between(triangle_normal(close, t), expected) < 1e-3);
  }
}

TEST_CASE("LoopLimitNormals_Border_AreWhatTheTrianglesTurnInto") {
  for (Index k = 2; k <= 6; ++k) {
    INFO("border valence " << k);
    const Mesh fan = test::to_naive(test::open_fan(k - 1));
    const Point expected = naive::loop_limit_normals(fan)[0];
    CHECK(expected.z > 0);
    // At k = 2 a level shrinks the fan by 4 in one direction and by 2 in the other. After 60 levels
    // there would be no exact digits.
    const Mesh close = zoomed(fan, k == 2 ? 10 : 60);
    for (std::size_t t = 0; t < close.triangles.size(); ++t)
      CHECK(naive::angle_between(triangle_normal(close, t), expected) < 1e-3);
  }
}

TEST_CASE("LoopLimitNormals_BorderValenceSeven_AreReachedSlowlyByTheInnerTriangles") {
  // Here 3/8 + cos(2 theta)/4 is 1/2 too, so the error falls as 1/levels and not as a power.
  const Mesh fan = test::to_naive(test::open_fan(6));
  const Point expected = naive::loop_limit_normals(fan)[0];
  const Mesh close = zoomed(fan, 60), closer = zoomed(fan, 120);
  for (const std::size_t t : {0u, 5u})
    CHECK(naive::angle_between(triangle_normal(close, t), expected) < 1e-3);
  for (const std::size_t t : {1u, 2u, 3u, 4u}) {
    const double before = naive::angle_between(triangle_normal(close, t), expected);
    const double after = naive::angle_between(triangle_normal(closer, t), expected);
    CHECK(before < 0.02);
    CHECK(after == Approx(before / 2).epsilon(0.2));
  }
}

TEST_CASE("LoopLimitNormals_BorderValenceFromEight_AreThoseOfTheBorderTriangles") {
  // At these valences the surface has no tangent plane; see naive_limit.h.
  for (Index k = 8; k <= 12; ++k) {
    INFO("border valence " << k);
    const Mesh fan = test::to_naive(test::open_fan(k - 1));
    const Point expected = naive::loop_limit_normals(fan)[0];
    const Mesh close = zoomed(fan, 100);
    CHECK(naive::angle_between(triangle_normal(close, 0), expected) < 1e-3);
    CHECK(naive::angle_between(triangle_normal(close, k - 2), expected) < 1e-3);
    double largest = 0;
    for (std::size_t t = 0; t < close.triangles.size(); ++t)
      largest = std::max(largest, naive::angle_between(triangle_normal(close, t), expected));
    CHECK(largest > 2e-3);
  }
}

TEST_CASE("BorderTangentWeights_FourNeighbours_AreHoppes") {
  const std::vector<double> found = naive::border_tangent_weights(4);
  const double hoppe[] = {-2, -1, 2, 2, -1};
  for (std::size_t k = 0; k < 5; ++k)
    CHECK(found[k] / found[2] == Approx(hoppe[k] / 2).margin(1e-14));
  for (std::size_t k = 2; k <= 40; ++k) {
    double sum = 0;
    for (const double value : naive::border_tangent_weights(k)) sum += value;
    CHECK(sum == Approx(0).margin(1e-12));
  }
}

TEST_CASE("LoopLimitNormals_RefinedSurfaces_AgreeWithTheirTriangles") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const Mesh fine = naive::subdivide(test::to_naive(indexed), naive::Scheme::kLoop, 4);
    const std::vector<Point> masks = naive::loop_limit_normals(fine);
    const std::vector<Point> triangles = naive::area_weighted_normals(fine);
    double sum = 0;
    for (std::size_t v = 0; v < masks.size(); ++v) {
      REQUIRE(naive::length(masks[v]) == Approx(1));
      sum += std::pow(naive::angle_between(masks[v], triangles[v]), 2);
    }
    CHECK(std::sqrt(sum / static_cast<double>(masks.size())) < 0.1);
  }
}
