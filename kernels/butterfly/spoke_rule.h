// The modified Butterfly rule at an extraordinary vertex, for all spokes of the vertex at once.
//
// D. Zorin, P. Schroeder, W. Sweldens, "Interpolating Subdivision for Meshes with Arbitrary
// Topology", SIGGRAPH 1996: 3/4 v + sum s_j e_j over the ring, j = 0 being the spoke itself,
// s_j = (1/n)(1/4 + cos(2 pi j/n) + 1/2 cos(4 pi j/n)) for n >= 5. These weights have only three
// frequencies. So three sums over the ring (a plain one, and two with sine and cosine) give the
// value on every spoke. The time for a vertex of valence n is proportional to n, not to n^2.
// Pinned by tests/kernels/schemes_test.cpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace plait::butterfly {

/// Calls set(k, new vertex next to v on spoke k) for each of the `valence` spokes. point(k) is the
/// old vertex on spoke k. Point is a type in double that has sums, and products with a number.
template <class Point, class Ring, class Set>
void for_each_spoke_value(int valence, const Point& v, Ring point, Set set) {
  const Point kept = 0.75 * v;
  if (valence < 5) {
    // There is no published rule for valence 2. These are the weights of valence 4, with those of
    // opposite spokes added.
    constexpr std::array<std::array<double, 4>, 3> kWeights = {{{3.0 / 8, -1.0 / 8, 0, 0},
                                                                {5.0 / 12, -1.0 / 12, -1.0 / 12, 0},
                                                                {3.0 / 8, 0, -1.0 / 8, 0}}};
    const auto& weights = kWeights[static_cast<std::size_t>(valence - 2)];
    for (int k = 0; k < valence; ++k) {
      Point sum{};
      for (int j = 0; j < valence; ++j)
        sum = sum + weights[static_cast<std::size_t>(j)] * point((k + j) % valence);
      set(k, kept + sum);
    }
    return;
  }
  const double step = 2 * std::numbers::pi / valence;
  Point plain{}, cosine1{}, sine1{}, cosine2{}, sine2{};
  for (int j = 0; j < valence; ++j) {
    const double angle = step * j;
    const Point p = point(j);
    plain = plain + p;
    cosine1 = cosine1 + std::cos(angle) * p;
    sine1 = sine1 + std::sin(angle) * p;
    cosine2 = cosine2 + std::cos(2 * angle) * p;
    sine2 = sine2 + std::sin(2 * angle) * p;
  }
  for (int k = 0; k < valence; ++k) {
    const double angle = step * k;
    set(k, kept + (1.0 / valence) *
                      (0.25 * plain + (std::cos(angle) * cosine1 + std::sin(angle) * sine1) +
                       0.5 * (std::cos(2 * angle) * cosine2 + std::sin(2 * angle) * sine2)));
  }
}

}  // namespace plait::butterfly
