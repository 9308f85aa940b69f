// plait/kernels/loop_patches.h: Loop subdivision in place, written once for any PatchMesh: plain
// arrays in memory (InCoreMesh) or a store far larger than memory (StorePatches).
//
// The loops are a program's own: they take the faces one after another and speak of vertices by
// (level, i, j). Equal, bit for bit, to the sweep executor's results; pinned by
// tests/kernels/executors_test.cpp. Levels count from the base mesh.
#pragma once

#include <cstdint>
#include <functional>

#include "plait/edge_index.h"
#include "plait/kernels/loop_base.h"
#include "plait/kernels/loop_rules.h"
#include "plait/kernels/patch_frames.h"
#include "plait/kernels/ring_table.h"
#include "plait/patch.h"

namespace plait {

/// Called before each face; may throw to stop.
using BeforeFace = std::function<void(FaceId)>;

/// The vertices next to the base vertices on the edges that the current patch owns, at `level`.
template <class Patch, class Record>
void collect_rings(const Patch& patch, const Topology& mesh, int level, RingTable<Record>& rings) {
  const std::int64_t last = slot_side(level) - 1;
  for (int side = 0; side < 3; ++side) {
    if (!mesh.is_own(patch.face(), side)) continue;
    const FaceIndex start = from_side(patch.face(), {side, level, last, 0});
    const FaceIndex end = from_side(patch.face(), {side, level, 0, last});
    rings.set(mesh.face_edges[patch.face()][static_cast<std::size_t>(side)],
              patch.at(level, start.i, start.j), patch.at(level, end.i, end.j));
  }
}

/// Makes the vertices born at `level` from the mesh one level coarser, and collects their rings.
template <PatchMesh Mesh>
void loop_odd_patches(Mesh& mesh, int level, RingTable<typename Mesh::Record>& rings,
                      const BeforeFace& before_face = {}) {
  using Record = typename Mesh::Record;
  const Topology topology = mesh.topology();
  mesh.activate(level, level, level);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    for_each_owned(
        patch, level, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
          const PatchFrame frame(patch, side, level, row, column, level);
          const Record& a = frame.coarse_at(-1, 1);
          const Record& b = frame.coarse_at(1, -1);
          frame.at(0, 0) =
              border ? loop::odd_border_vertex(a, b)
                     : loop::odd_vertex(a, b, frame.coarse_at(-1, -1), frame.coarse_at(1, 1));
        });
    collect_rings(patch, topology, level, rings);
  }
}

/// Moves the vertices born at levels 1 to level - 1, from the new ones at `level`.
template <PatchMesh Mesh>
void loop_even_patches(Mesh& mesh, int level, const BeforeFace& before_face = {}) {
  using Record = typename Mesh::Record;
  const Topology topology = mesh.topology();
  mesh.activate(level, 1, level - 1);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    for (int born = 1; born < level; ++born)
      for_each_owned(
          patch, born, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
            const PatchFrame frame(patch, side, born, row, column, level);
            Record& v = frame.at(0, 0);
            v = border ? loop::even_border_vertex(v, frame.at(-1, 1), frame.at(1, -1))
                       : loop::even_vertex(v, frame.at(1, 0), frame.at(0, 1), frame.at(-1, 1),
                                           frame.at(-1, 0), frame.at(0, -1), frame.at(1, -1));
          });
  }
}

/// One level of Loop subdivision, base vertices and all.
template <PatchMesh Mesh>
void loop_refine_patches(Mesh& mesh, int level) {
  RingTable<typename Mesh::Record> rings(mesh.topology().edges.size());
  loop_odd_patches(mesh, level, rings);
  loop_even_patches(mesh, level);
  loop::even_base(mesh.topology(), rings, mesh.base_records());
}

}  // namespace plait
