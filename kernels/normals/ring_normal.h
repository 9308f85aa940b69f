// The normal of a vertex that a visit gives with its neighbours, by the rule of subdivide().
#pragma once

#include <cstddef>

#include "normals/normal_rules.h"
#include "plait/vertex_rings.h"

namespace plait::normals {

/// The normal at vertex `i` of a run. Base vertices come from one thread only, so one object of
/// masks is enough for all threads.
template <class Real>
Vector3<float> at_vertex(const VertexRun& run, const VertexRings<Vector3<Real>>& ring,
                         std::size_t i, BaseMasks& masks) {
  const auto at = [&](int k) -> const Vector3<Real>& { return ring.neighbour(i, k); };
  if (run.is_base())
    return of_base_vertex(masks.of(ring.valence(), ring.is_border()), widen(ring.vertex(i)),
                          [&](int k) { return widen(at(k)); });
  return ring.is_border() ? RegularNormal::border(ring.vertex(i), at(0), at(1), at(2), at(3))
                          : regular(at(0) - at(3), at(1) - at(4), at(2) - at(5));
}

}  // namespace plait::normals
