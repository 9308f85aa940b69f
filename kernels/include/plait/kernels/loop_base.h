// plait/kernels/loop_base.h: Loop's rules at the base vertices, of any valence, from their rings.
// Evaluated in double: a sum over a hundred thousand neighbours has no digits left in float.
#pragma once

#include <span>

#include "plait/kernels/loop_rules.h"
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

struct BaseRing {
  int valence = 0;
  Vector3<double> sum{}, first{}, last{};
};

template <class Real>
BaseRing read_ring(const Topology& mesh, const RingTable<Vector3<Real>>& rings, VertexId vertex) {
  BaseRing ring;
  for_each_spoke(mesh, vertex, [&](EdgeId edge) {
    const Vector3<double> point = widen(rings.next_to(mesh, edge, vertex));
    if (ring.valence == 0) ring.first = point;
    ring.last = point;
    ring.sum = ring.sum + point;
    ++ring.valence;
  });
  return ring;
}

/// Where a base vertex moves to; `ring` holds the new odd vertices around it.
inline Vector3<double> moved_base(const BaseRing& ring, bool border, const Vector3<double>& v) {
  if (border) return by_axis<double>(even_border<double>, v, ring.first, ring.last);
  const double weight = odd_neighbour_weight(ring.valence);
  return (1 - ring.valence * weight) * v + weight * ring.sum;
}

/// Limit position of a base vertex; `ring` is the finest level's.
inline Vector3<double> limit_of_base(const BaseRing& ring, bool border, const Vector3<double>& v) {
  if (border) return by_axis<double>(limit_border<double>, v, ring.first, ring.last);
  const double weight = limit_weight(ring.valence);
  return (1 - ring.valence * weight) * v + weight * ring.sum;
}

/// Moves every base vertex; `rings` holds the new odd vertices around them.
template <class Real>
void even_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
               std::span<Vector3<Real>> base) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex)
    base[vertex] = narrow<Real>(moved_base(read_ring(mesh, rings, vertex),
                                           is_border_vertex(mesh, vertex), widen(base[vertex])));
}

/// Limit positions of the base vertices; `rings` holds the finest level's.
template <class Real>
void limit_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                std::span<const Vector3<Real>> base, std::span<Vector3<Real>> limits) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex)
    limits[vertex] = narrow<Real>(limit_of_base(
        read_ring(mesh, rings, vertex), is_border_vertex(mesh, vertex), widen(base[vertex])));
}

}  // namespace plait::loop
