// The edges that a kernel may access when it works on one edge.
#pragma once

#include "plait/extend/sweep.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls visit(EdgeId) for the edges within `reach` of `edge`, some of them more than once.
template <class Visit>
void for_each_edge_in_reach(const Topology& mesh, EdgeId edge, Reach reach, Visit visit) {
  visit(edge);
  if (reach == Reach::kOwn) return;
  for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other}) {
    if (!side.exists()) continue;
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(side.face(), (side.side() + turn) % 3);
      visit(mesh.face_edges[outer.face()][static_cast<std::size_t>(outer.side())]);
      if (reach != Reach::kRing) continue;
      const FaceSide beyond = mesh.across(outer);
      if (!beyond.exists()) continue;
      for (const EdgeId further : mesh.face_edges[beyond.face()]) visit(further);
    }
  }
}

PLAIT_END_NAMESPACE
