// Linear subdivision over any PatchMesh; see plait/kernels/loop_patches.h.
#pragma once

#include "loop/loop_expressions.h"
#include "midpoint/midpoint_diamond.h"
#include "plait/kernels/loop_patches.h"

namespace plait {

template <PatchMesh Mesh>
void midpoint_odd_patches(Mesh& mesh, int level, RingTable<typename Mesh::Record>& rings,
                          const BeforeFace& before_face = {}) {
  using Real = decltype(Mesh::Record::x);
  const Topology topology = mesh.topology();
  mesh.activate(level, level, level);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    for_each_owned(patch, level, [&](auto side, std::int64_t row, std::int64_t column, bool) {
      const PatchFrame frame(patch, side, level, row, column, level);
      frame.at(0, 0) =
          loop::by_axis<Real>(midpoint::odd<Real>, frame.coarse_at(-1, 1), frame.coarse_at(1, -1));
    });
    collect_rings(patch, topology, level, rings);
  }
}

}  // namespace plait
