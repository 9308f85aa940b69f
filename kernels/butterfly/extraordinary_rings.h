// The modified Butterfly rule at extraordinary base vertices, for all spokes of a vertex at once.
//
// D. Zorin, P. Schroeder, W. Sweldens 1996: 3/4 v + sum s_j e_j over the ring, j = 0 being the
// spoke itself, s_j = (1/n)(1/4 + cos(2 pi j/n) + 1/2 cos(4 pi j/n)) for n >= 5. These weights have
// three frequencies only, so three sums over the ring (one of them plain, two with sine and cosine)
// give the value on every spoke, and a vertex of valence n costs n and not n^2.
// Pinned by tests/kernels/schemes_test.cpp.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "plait/kernels/loop_base.h"
#include "plait/kernels/ring_table.h"
#include "plait/topology.h"
#include "plait/vector3.h"

namespace plait::butterfly {

template <class Real>
class ExtraordinaryRings {
 public:
  /// `rings` holds the rings of the coarser level. Vertices on a border count as regular.
  ExtraordinaryRings(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                     std::span<const Vector3<Real>> base)
      : mesh_(mesh), extraordinary_(base.size(), false), values_(mesh.edges.size()) {
    std::vector<EdgeId> spokes;
    std::vector<Vector3<double>> points;
    for (VertexId vertex = 0; vertex < base.size(); ++vertex) {
      if (is_border_vertex(mesh, vertex)) continue;
      spokes.clear();
      for_each_spoke(mesh, vertex, [&](EdgeId edge) { spokes.push_back(edge); });
      if (spokes.size() == 6) continue;
      extraordinary_[vertex] = true;
      points.clear();
      for (const EdgeId edge : spokes)
        points.push_back(loop::widen(rings.next_to(mesh, edge, vertex)));
      evaluate(vertex, loop::widen(base[vertex]), spokes, points);
    }
  }

  bool contains(VertexId vertex) const { return extraordinary_[vertex]; }

  /// The odd vertex on `edge` that is next to its start or its end (at level 1: to both), where
  /// `at_start` and `at_end` say which of these are extraordinary.
  Vector3<Real> odd(EdgeId edge, bool at_start, bool at_end) const {
    const auto& [start, end] = values_[edge];
    return loop::narrow<Real>(at_start && at_end ? 0.5 * (end + start) : at_end ? end : start);
  }

 private:
  void evaluate(VertexId vertex, const Vector3<double>& v, std::span<const EdgeId> spokes,
                std::span<const Vector3<double>> points) {
    const std::size_t n = points.size();
    const auto set = [&](std::size_t k, const Vector3<double>& ring_part) {
      values_[spokes[k]][mesh_.edges[spokes[k]].end == vertex] = 0.75 * v + ring_part;
    };
    if (n < 5) {
      // Valence 2 has no published rule: the weights of valence 4 with opposite spokes folded.
      constexpr std::array<std::array<double, 4>, 3> kWeights = {
          {{3.0 / 8, -1.0 / 8, 0, 0},
           {5.0 / 12, -1.0 / 12, -1.0 / 12, 0},
           {3.0 / 8, 0, -1.0 / 8, 0}}};
      for (std::size_t k = 0; k < n; ++k) {
        Vector3<double> sum{};
        for (std::size_t j = 0; j < n; ++j) sum = sum + kWeights[n - 2][j] * points[(k + j) % n];
        set(k, sum);
      }
      return;
    }
    const double step = 2 * std::numbers::pi / static_cast<double>(n);
    Vector3<double> plain{}, cosine1{}, sine1{}, cosine2{}, sine2{};
    for (std::size_t j = 0; j < n; ++j) {
      const double angle = step * static_cast<double>(j);
      plain = plain + points[j];
      cosine1 = cosine1 + std::cos(angle) * points[j];
      sine1 = sine1 + std::sin(angle) * points[j];
      cosine2 = cosine2 + std::cos(2 * angle) * points[j];
      sine2 = sine2 + std::sin(2 * angle) * points[j];
    }
    for (std::size_t k = 0; k < n; ++k) {
      const double angle = step * static_cast<double>(k);
      set(k, (1 / static_cast<double>(n)) *
                 (0.25 * plain + (std::cos(angle) * cosine1 + std::sin(angle) * sine1) +
                  0.5 * (std::cos(2 * angle) * cosine2 + std::sin(2 * angle) * sine2)));
    }
  }

  Topology mesh_;
  std::vector<bool> extraordinary_;                     ///< [vertex]
  std::vector<std::array<Vector3<double>, 2>> values_;  ///< [edge] next to start, next to end
};

}  // namespace plait::butterfly
