#include "sample/sample_ring.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "sample/samples.h"
#include "support/test_meshes.h"

namespace plait::test {
TEST_CASE("SampleNumbers_EveryMesh_NameEachVertexOnce") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const BaseMesh base = BaseMesh::build(named.mesh);
    for (const int level : {0, 1, 2, 3}) {
      const SampleNumbers numbers(base, level);
      CHECK(numbers.count() == counts_at_level(base, level).vertices);
      // The flat position of a vertex follows from every face that has it.
      const Point nowhere{1e9, 1e9, 1e9};
      std::vector<Point> places(numbers.count(), nowhere);
      std::size_t differences = 0;
      const auto size = static_cast<double>(numbers.size());
      for (FaceId face = 0; face < base.face_count(); ++face) {
        const auto& [a, b, c] = base.faces()[face];
        for (std::int64_t j = 0; j <= numbers.size(); ++j)
          for (std::int64_t i = 0; i + j <= numbers.size(); ++i) {
            const double u = static_cast<double>(i) / size, v = static_cast<double>(j) / size;
            const Point p = (1 - u - v) * base.positions()[a] + u * base.positions()[b] +
                            v * base.positions()[c];
            Point& place = places.at(numbers.of(face, i, j));
            if (place == nowhere)
              place = p;
            else if (length(place - p) > 1e-9)
              ++differences;
          }
      }
      CHECK(differences == 0);
      CHECK(std::count(places.begin(), places.end(), nowhere) == 0);
    }
  }
}

TEST_CASE("SampleNumbers_TrianglesOfFace_CoverIt") {
  const BaseMesh base = BaseMesh::build(single_triangle());
  const SampleNumbers numbers(base, 3);
  std::set<std::set<std::uint64_t>> triangles;
  numbers.for_each_triangle(0, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    triangles.insert({a, b, c});
  });
  CHECK(triangles.size() == 64);
}

// The estimate of small triangles' distances is that of a quadratic surface, and has one value
// whichever way it is asked for.

namespace {

/// z = (a x^2 + b x y + c y^2) / 2.
struct Quadratic {
  double a, b, c;

  Point at(double x, double y) const { return {x, y, (a * x * x + b * x * y + c * y * y) / 2}; }
  OrientedPoint oriented(double x, double y) const {
    return {at(x, y), normalized(Point{-a * x - b * y / 2, -b * x / 2 - c * y, 1})};
  }
};

using Corners = std::array<std::array<double, 2>, 3>;

/// The mean of the squared heights of the surface over the triangle, by many points.
double mean_square_of(const Quadratic& surface, const Corners& corners) {
  constexpr int kParts = 120;
  double sum = 0, count = 0;
  for (int j = 0; j < kParts; ++j)
    for (int i = 0; i + j < kParts; ++i) {
      const double u = (i + 1.0 / 3) / kParts, v = (j + 1.0 / 3) / kParts, w = 1 - u - v;
      double x = 0, y = 0, z = 0;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const double weight = corner == 0 ? w : corner == 1 ? u : v;
        const Point p = surface.at(corners[corner][0], corners[corner][1]);
        x += weight * p.x;
        y += weight * p.y;
        z += weight * p.z;
      }
      const double height = surface.at(x, y).z - z;
      sum += height * height;
      ++count;
    }
  return sum / count;
}

/// A sample and six others around it on a bumpy surface.
struct RandomRing {
  OrientedPoint sample;
  SampleRing ring;

  explicit RandomRing(std::mt19937& random) {
    std::uniform_real_distribution<double> some(-0.3, 0.3);
    const Quadratic surface{some(random), some(random), some(random)};
    std::vector<OrientedPoint> around;
    for (int i = 0; i < 6; ++i)
      around.push_back(
          surface.oriented(std::cos(i * 1.05) + some(random), std::sin(i * 1.05) + some(random)));
    for (std::size_t i = 0; i < 6; ++i) ring.add(around[i], around[(i + 1) % 6], 0.8);
    sample = surface.oriented(some(random), some(random));
  }
};

}  // namespace

TEST_CASE("SampleRing_TriangleOfAQuadraticSurface_HasItsMeanSquare") {
  const Corners corners = {{{0.1, 0.0}, {0.9, 0.2}, {0.3, 0.8}}};
  // A bowl, a saddle, a saddle between the axes, a cylinder, and others between them.
  for (const Quadratic& surface :
       {Quadratic{0.05, 0, 0.05}, Quadratic{0.05, 0, -0.05}, Quadratic{0, 0.08, 0},
        Quadratic{0.05, 0, 0}, Quadratic{-0.04, 0.03, 0.01}}) {
    std::array<OrientedPoint, 3> curved, flat;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      curved[corner] = surface.oriented(corners[corner][0], corners[corner][1]);
      flat[corner] = {curved[corner].position, {0, 0, 1}};
    }
    // With equal normals, what is left is the share that keeps flat parts even.
    const double error = triangle_error(curved[0], curved[1], curved[2], 1) -
                         triangle_error(flat[0], flat[1], flat[2], 1);
    CHECK(4 * error / 45 == Approx(mean_square_of(surface, corners)).epsilon(0.02));
  }
}

TEST_CASE("SampleRing_EstimateOfARing_IsTheSumOfItsTriangles") {
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    const RandomRing made(random);
    CHECK(made.ring.estimate(made.sample).error > 0);
  }
  const Quadratic surface{0.2, 0.1, -0.1};
  const OrientedPoint p = surface.oriented(0, 0), q = surface.oriented(1, 0),
                      r = surface.oriented(0, 1), s = surface.oriented(-1, 0.2);
  SampleRing ring;
  ring.add(q, r, 1);
  ring.add(r, s, 1);
  const auto area = [&](const OrientedPoint& a, const OrientedPoint& b) {
    return length(area_vector(p.position, a.position, b.position));
  };
  CHECK(ring.estimate(p).error ==
        Approx(triangle_error(p, q, r, area(q, r)) + triangle_error(p, r, s, area(r, s))));
}

TEST_CASE("SampleRing_ErrorWithinLimits_IsTheEstimateOrNone") {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> some(0.5, 1.5);
  std::array<int, 4> seen{};
  for (int i = 0; i < 2000; ++i) {
    const RandomRing made(random);
    const RingEstimate estimate = made.ring.estimate(made.sample);
    const RingLimits limits = {estimate.error * some(random), estimate.least_turn * some(random),
                               estimate.most_ratio * some(random)};
    const bool error = estimate.error < limits.error,
               turn = estimate.least_turn >= limits.least_turn,
               ratio = estimate.most_ratio <= limits.most_ratio;
    ++seen[error && turn && ratio ? 0 : !error ? 1 : !turn ? 2 : 3];
    const auto found = made.ring.error_within(made.sample, limits);
    REQUIRE(found.has_value() == (error && turn && ratio));
    if (found) REQUIRE(*found == Approx(estimate.error));
  }
  CHECK(*std::min_element(seen.begin(), seen.end()) > 20);
}

}  // namespace plait::test
