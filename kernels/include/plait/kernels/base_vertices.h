// plait/kernels/base_vertices.h: a rule at the base vertices, of any valence, from their rings.
// Evaluated in double, and functions of the library. `Real` is float or double.
#pragma once

#include <span>

#include "plait/kernels/one_ring.h"
#include "plait/kernels/ring_table.h"
#include "plait/topology.h"
#include "plait/vector3.h"

namespace plait {

/// Moves every base vertex; `rings` holds the new odd vertices around them. REQUIRES:
/// rule.moves_even().
template <class Real>
void move_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                        const OneRing<Real>& rule, std::span<Vector3<Real>> base);

/// Limit positions of the base vertices; `rings` holds the finest level's. REQUIRES:
/// rule.has_limits().
template <class Real>
void limit_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                         const OneRing<Real>& rule, std::span<const Vector3<Real>> base,
                         std::span<Vector3<Real>> limits);

}  // namespace plait
