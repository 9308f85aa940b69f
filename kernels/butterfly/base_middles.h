// Computes level 1 of the modified Butterfly scheme from the base mesh. Only at this level can both
// ends of an edge, and any vertex of its stencil, be extraordinary.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "butterfly/odd_slots.h"
#include "butterfly/rings.h"
#include "butterfly/stencils.h"
#include "plait/detail/numbers.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

namespace plait::butterfly {

/// The vertex across a side of a face. At a border, its continuation.
template <class Real>
Vector3<Real> base_wing(const Topology& mesh, std::span<const Vector3<Real>> base, FaceId face,
                        int side) {
  const FaceSide beyond = mesh.across(FaceSide(face, side));
  if (beyond.exists())
    return base[mesh.faces[beyond.face()][static_cast<std::size_t>(beyond.side())]];
  const auto corner = [&](int k) {
    return base[mesh.faces[face][static_cast<std::size_t>(k % 3)]];
  };
  return continued(corner(side + 1), corner(side + 2), corner(side));
}

/// Returns the vertices of level 1: [edge]. Pinned by tests/kernels/fused_digest_test.cpp, which
/// compares them with the sweep.
template <class Real>
std::vector<Vector3<Real>> base_middles(const Topology& mesh, std::span<const Vector3<Real>> base) {
  RingTable<Vector3<Real>> rings(mesh.edges.size());
  rings.set_from_base(mesh, base);
  const ExtraordinaryRings<Real> extraordinary(mesh, rings, base);
  std::vector<Vector3<Real>> middles(mesh.edges.size());
  for (EdgeId id = 0; id < mesh.edges.size(); ++id) {
    const Edge& edge = mesh.edges[id];
    const Vector3<Real>&a = base[edge.end], &b = base[edge.start];
    const bool odd_start = extraordinary.contains(edge.start),
               odd_end = extraordinary.contains(edge.end);
    if (edge.is_border()) {
      middles[id] = odd_border(along_border(mesh, rings, edge.end, id), a, b,
                               along_border(mesh, rings, edge.start, id));
    } else if (odd_start || odd_end) {
      middles[id] = extraordinary.odd(id, odd_start, odd_end);
    } else {
      // In its own face, the edge starts at the corner after the corner opposite its side. In the
      // other face, it ends there.
      const auto [own, own_side] = std::pair(edge.own.face(), edge.own.side());
      const auto [other, other_side] = std::pair(edge.other.face(), edge.other.side());
      const auto wing = [&](FaceId face, int side) {
        return base_wing(mesh, base, face, side % 3);
      };
      middles[id] = odd(a, b, base[mesh.faces[own][static_cast<std::size_t>(own_side)]],
                        base[mesh.faces[other][static_cast<std::size_t>(other_side)]],
                        wing(own, own_side + 1), wing(other, other_side + 1),
                        wing(own, own_side + 2), wing(other, other_side + 2));
    }
  }
  return middles;
}

}  // namespace plait::butterfly

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The vertices of level 1, [edge], from which the rings of base vertices begin.
template <class Real>
std::vector<Vector3<Real>> first_middles(const Butterfly<Real>&, const Topology& mesh,
                                         std::span<const Vector3<Real>> base) {
  return butterfly::base_middles(mesh, base);
}

PLAIT_END_NAMESPACE
