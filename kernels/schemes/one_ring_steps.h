// The functions and types that the executors' steps need from a scheme, for one-ring schemes.
// kernels/butterfly/ has those for Butterfly.
#pragma once

#include <span>
#include <vector>

#include "plait/detail/gather_grid.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Computes the new vertices of one level, edge by edge.
template <class Real>
auto odd_slots(const OneRing<Real>& rule, const Topology& mesh, const RingTable<Vector3<Real>>&,
               std::span<const Vector3<Real>>) {
  return [rule, mesh](const SlotSource<Vector3<Real>>&, EdgeId edge,
                      const EdgeGrid<Vector3<Real>>& grid, const SlotRecords<Vector3<Real>>& slot) {
    rule.odd_slot(grid, {slot.shape, mesh.edges[edge].is_border()}, slot.data());
  };
}

/// For one-ring schemes, the rings of base vertices begin with the base mesh itself.
template <class Real>
std::vector<Vector3<Real>> first_middles(const OneRing<Real>&, const Topology&,
                                         std::span<const Vector3<Real>>) {
  return {};
}

PLAIT_END_NAMESPACE
