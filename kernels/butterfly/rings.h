// butterfly/rings.h: the rings around base vertices.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "butterfly/stencils.h"
#include "fused/patch_lattice.h"
#include "plait/detail/numbers.h"
#include "plait/detail/ring_table.h"
#include "plait/detail/rows.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

// Computes the points beyond the two border edges of a border vertex, which Butterfly stencils
// read.

namespace plait::butterfly {

/// Continues the rings of border vertices, one in each lane, beyond the first and the last spoke.
template <class Real>
void continue_ring(int valence, Real* points) {
  using enum RingPart;
  const RingShape shape{valence, true, 2};
  const auto at = [&](RingPart ring, int spoke) {
    return points + shape.point(ring, spoke) * kPointNumbers;
  };
  const auto put = [](Real* to, const Real* end0, const Real* end1, const Real* inside) {
    for (std::size_t k = 0; k < kPointNumbers; ++k) to[k] = continued(end0[k], end1[k], inside[k]);
  };
  const int last = valence - 1;
  put(at(kNear, -1), points, at(kNear, 0), at(kNear, 1));
  put(at(kNear, valence), points, at(kNear, last), at(kNear, last - 1));
  put(at(kBetween, -1), at(kNear, 0), at(kFar, 0), at(kBetween, 0));
  put(at(kBetween, last), at(kNear, last), at(kFar, last), at(kBetween, last - 1));
}

// Evaluates the modified Butterfly rule at all extraordinary base vertices of a mesh, once for each
// level.

template <class Real>
class ExtraordinaryRings {
 public:
  /// `rings` has the rings of the coarser level. Vertices on a border count as regular.
  ExtraordinaryRings(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                     std::span<const Vector3<Real>> base)
      : extraordinary_(base.size(), false), values_(mesh.edges.size()) {
    std::vector<EdgeId> spokes;
    std::vector<Vector3<double>> points;
    for (VertexId vertex = 0; vertex < base.size(); ++vertex) {
      if (is_border_vertex(mesh, vertex)) continue;
      spokes.clear();
      for_each_spoke(mesh, vertex, [&](EdgeId edge) { spokes.push_back(edge); });
      if (spokes.size() == 6) continue;
      extraordinary_[vertex] = true;
      points.clear();
      for (const EdgeId edge : spokes) points.push_back(widen(rings.next_to(mesh, edge, vertex)));
      for_each_spoke_value(
          static_cast<int>(spokes.size()), widen(base[vertex]),
          [&](int k) { return points[static_cast<std::size_t>(k)]; },
          [&](int k, const Vector3<double>& value) {
            const EdgeId edge = spokes[static_cast<std::size_t>(k)];
            values_[edge][mesh.edges[edge].end == vertex] = value;
          });
    }
  }

  bool contains(VertexId vertex) const { return extraordinary_[vertex]; }

  /// The odd vertex on `edge` that is next to its start or its end (at level 1, next to both).
  /// `at_start` and `at_end` tell which of these are extraordinary.
  Vector3<Real> odd(EdgeId edge, bool at_start, bool at_end) const {
    const auto& [start, end] = values_[edge];
    return narrow<Real>(at_start && at_end ? 0.5 * (end + start) : at_end ? end : start);
  }

 private:
  std::vector<bool> extraordinary_;                     ///< [vertex]
  std::vector<std::array<Vector3<double>, 2>> values_;  ///< [edge] next to start, next to end
};

}  // namespace plait::butterfly
