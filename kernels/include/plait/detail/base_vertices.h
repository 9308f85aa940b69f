// plait/detail/base_vertices.h: applies a rule to the base vertices, which may have any valence.
// It reads their rings and computes in double. The library contains both functions for `Real` =
// float and double.
#pragma once

#include <span>

#include "plait/detail/namespace.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// Moves every base vertex. `rings` has the new odd vertices around each. REQUIRES:
/// rule.moves_even().
template <class Real>
PLAIT_EXPORT void move_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                                     const OneRing<Real>& rule, std::span<Vector3<Real>> base);

/// Computes the limit positions of the base vertices. `rings` has their neighbours at the finest
/// level. REQUIRES: rule.has_limits().
template <class Real>
PLAIT_EXPORT void limit_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                                      const OneRing<Real>& rule,
                                      std::span<const Vector3<Real>> base,
                                      std::span<Vector3<Real>> limits);

PLAIT_END_NAMESPACE
