// The modified Butterfly scheme over any PatchMesh; see plait/extend/rule_patches.h.
#pragma once

#include "butterfly/odd_slots.h"
#include "plait/extend/rule_patches.h"

namespace plait::butterfly {

/// An odd vertex that is not next to an extraordinary vertex or to the end of a border edge.
template <class Real, int kSide, class Patch>
Vector3<Real> odd_in_patch(const PatchFrame<kSide, Patch>& frame) {
  using Record = Vector3<Real>;
  const Record& a = frame.coarse_at(-1, 1);
  const Record& b = frame.coarse_at(1, -1);
  const Record& c = frame.coarse_at(-1, -1);
  const Record& d = frame.coarse_at(1, 1);
  const auto wing = [&](int p, int q, const Record& end0, const Record& end1,
                        const Record& inside) -> Record {
    return frame.exists(p, q) ? frame.coarse_at(p, q) : continued(end0, end1, inside);
  };
  return odd(a, b, c, d, wing(-3, 1, a, c, b), wing(3, -1, b, d, a), wing(1, -3, b, c, a),
             wing(-1, 3, a, d, b));
}

}  // namespace plait::butterfly

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Computes the vertices that `level` creates. `base` has the records of the base vertices, which
/// do not change. `rings` has the rings of level - 1; the function replaces them by those of
/// `level`.
template <PatchMesh Mesh, class Real>
void odd_patches(Mesh& mesh, int level, const Butterfly<Real>&,
                 std::span<const typename Mesh::Record> base,
                 RingTable<typename Mesh::Record>& rings, const BeforeFace& before_face = {}) {
  using Record = typename Mesh::Record;
  const Topology topology = mesh.topology();
  const RingTable<Record> coarse = rings;
  const butterfly::ExtraordinaryRings<Real> extraordinary(topology, coarse, base);
  mesh.activate(level, level, level);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    const std::int64_t last = patch.size(level) / 2 - 1;
    for_each_owned(
        patch, level, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
          const PatchFrame frame(patch, side, level, row, column, level);
          const EdgeId edge = topology.face_edges[face][static_cast<std::size_t>(side())];
          const Edge& ends = topology.edges[edge];
          Record& to = frame.at(0, 0);
          // The points next to the ends of an edge are on the edge, so only the patch that owns the
          // edge computes them.
          const bool at_end = patch.owns(side) && row == 0 && column == last;
          const bool at_start = patch.owns(side) && row == last && column == 0;
          if (border) {
            const Record before = at_end ? butterfly::along_border(topology, coarse, ends.end, edge)
                                         : frame.coarse_at(-3, 3);
            const Record after = at_start
                                     ? butterfly::along_border(topology, coarse, ends.start, edge)
                                     : frame.coarse_at(3, -3);
            to = butterfly::odd_border(before, frame.coarse_at(-1, 1), frame.coarse_at(1, -1),
                                       after);
            return;
          }
          const bool odd_end = at_end && extraordinary.contains(ends.end);
          const bool odd_start = at_start && extraordinary.contains(ends.start);
          to = odd_end || odd_start ? extraordinary.odd(edge, odd_start, odd_end)
                                    : butterfly::odd_in_patch<Real>(frame);
        });
    collect_rings(patch, topology, level, rings);
  }
}

PLAIT_END_NAMESPACE
