#include "collapse/quadric.h"

#include <catch2/catch.hpp>
#include <random>

namespace plait::test {

TEST_CASE("Quadric_PlanesAndPoints_IsSumOfSquaredDistances") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Point{number(random), number(random), number(random)}; };
  for (int round = 0; round < 20; ++round) {
    Quadric sum;
    const Point at = point();
    double expected = 0;
    for (int i = 0; i < 5; ++i) {
      Quadric one;
      const Point normal = normalized(point()), through = point(), near = point();
      one.add_plane(normal, through, 2);
      one.add_point(near, 0.5);
      sum = sum + one;
      const double height = dot(normal, at - through);
      expected += 2 * height * height + 0.5 * squared_length(at - near);
    }
    CHECK(sum.at(at) == Approx(expected));
    const Point best = sum.minimum({9, 9, 9});
    const double least = sum.at(best);
    for (const Point step : {Point{1e-3, 0, 0}, Point{0, 1e-3, 0}, Point{0, 0, 1e-3}}) {
      CHECK(sum.at(best + step) > least);
      CHECK(sum.at(best - step) > least);
    }
  }
}

TEST_CASE("Quadric_OnePlane_HasNoSingleMinimum") {
  Quadric plane;
  plane.add_plane({0, 0, 1}, {0, 0, 3}, 1);
  CHECK(plane.minimum({4, 5, 6}) == Point{4, 5, 6});
}

}  // namespace plait::test
