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

/// Moves every base vertex; `rings` holds the new odd vertices around them.
template <class Real>
void even_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
               std::span<Vector3<Real>> base) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex) {
    const BaseRing ring = read_ring(mesh, rings, vertex);
    const Vector3<double> v = widen(base[vertex]);
    if (is_border_vertex(mesh, vertex)) {
      base[vertex] = narrow<Real>(by_axis<double>(even_border<double>, v, ring.first, ring.last));
    } else {
      const double weight = odd_neighbour_weight(ring.valence);
      base[vertex] = narrow<Real>((1 - ring.valence * weight) * v + weight * ring.sum);
    }
  }
}

/// Limit positions of the base vertices; `rings` holds the finest level's.
template <class Real>
void limit_base(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                std::span<const Vector3<Real>> base, std::span<Vector3<Real>> limits) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex) {
    const BaseRing ring = read_ring(mesh, rings, vertex);
    const Vector3<double> v = widen(base[vertex]);
    if (is_border_vertex(mesh, vertex)) {
      limits[vertex] =
          narrow<Real>(by_axis<double>(limit_border<double>, v, ring.first, ring.last));
    } else {
      const double weight = limit_weight(ring.valence);
      limits[vertex] = narrow<Real>((1 - ring.valence * weight) * v + weight * ring.sum);
    }
  }
}

}  // namespace plait::loop
