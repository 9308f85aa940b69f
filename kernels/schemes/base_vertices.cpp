#include "plait/detail/base_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

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

}  // namespace

template <class Real>
void move_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                        const OneRing<Real>& rule, std::span<Vector3<Real>> base) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex)
    base[vertex] = narrow<Real>(rule.even_base(
        read_ring(mesh, rings, vertex), is_border_vertex(mesh, vertex), widen(base[vertex])));
}

template <class Real>
void limit_base_vertices(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                         const OneRing<Real>& rule, std::span<const Vector3<Real>> base,
                         std::span<Vector3<Real>> limits) {
  for (VertexId vertex = 0; vertex < base.size(); ++vertex)
    limits[vertex] = narrow<Real>(rule.limit_base(
        read_ring(mesh, rings, vertex), is_border_vertex(mesh, vertex), widen(base[vertex])));
}

template void move_base_vertices(const Topology&, const RingTable<Vector3<float>>&,
                                 const OneRing<float>&, std::span<Vector3<float>>);
template void limit_base_vertices(const Topology&, const RingTable<Vector3<float>>&,
                                  const OneRing<float>&, std::span<const Vector3<float>>,
                                  std::span<Vector3<float>>);
template void move_base_vertices(const Topology&, const RingTable<Vector3<double>>&,
                                 const OneRing<double>&, std::span<Vector3<double>>);
template void limit_base_vertices(const Topology&, const RingTable<Vector3<double>>&,
                                  const OneRing<double>&, std::span<const Vector3<double>>,
                                  std::span<Vector3<double>>);

PLAIT_END_NAMESPACE
