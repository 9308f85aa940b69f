// Evaluates the modified Butterfly rule at all extraordinary base vertices of a mesh, once for each
// level.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "butterfly/spoke_rule.h"
#include "plait/detail/numbers.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

namespace plait::butterfly {

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
