// plait/kernels/loop_base.h: Loop's rules at the base vertices, of any valence, from their rings.
//
// Evaluated in double, and functions of the library as those of plait/kernels/loop_rules.h are.
// `Real` is float or double.
#pragma once

#include <span>

#include "plait/kernels/ring_table.h"
#include "plait/topology.h"
#include "plait/vector3.h"

namespace plait::loop {

template <class Real>
Vector3<double> widen(const Vector3<Real>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}
template <class Real>
Vector3<Real> narrow(const Vector3<double>& v) {
  return {static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
}

/// Moves every base vertex; `rings` holds the new odd vertices around them.
template <class Real>
void even_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
               std::span<Vector3<Real>> base);

/// Limit positions of the base vertices; `rings` holds the finest level's.
template <class Real>
void limit_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                std::span<const Vector3<Real>> base, std::span<Vector3<Real>> limits);

}  // namespace plait::loop
