// plait/extend/rule_patches.h: subdivision in place by a one-ring rule. The same code works on any
// PatchMesh: plain arrays in memory (InCoreMesh) or a store far larger than memory (StorePatches).
//
// The loops visit one face after another and address vertices by (level, i, j), as a user's own
// program would. The results equal those of the sweep executor bit for bit; pinned by
// tests/kernels/executors_test.cpp. Levels are numbered as in the mesh: for a store, they count
// from the user's mesh.
#pragma once

#include <cstdint>
#include <functional>

#include "plait/detail/base_vertices.h"
#include "plait/detail/namespace.h"
#include "plait/detail/one_ring.h"
#include "plait/detail/patch_frames.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/patch.h"

PLAIT_BEGIN_NAMESPACE

/// Called before each face. It may throw an exception to stop.
using BeforeFace = std::function<void(FaceId)>;

/// Collects the vertices at `level` that are next to base vertices on the edges that the patch
/// owns.
template <class Patch, class Record>
void collect_rings(const Patch& patch, const Topology& mesh, int level, RingTable<Record>& rings) {
  const std::int64_t last = patch.size(level) / 2 - 1;
  const auto collect = [&](auto side) {
    if (!mesh.is_own(patch.face(), side)) return;
    rings.set(mesh.face_edges[patch.face()][static_cast<std::size_t>(side())],
              PatchFrame(patch, side, level, last, 0, level).at(0, 0),
              PatchFrame(patch, side, level, 0, last, level).at(0, 0));
  };
  collect(PatchSide<0>());
  collect(PatchSide<1>());
  collect(PatchSide<2>());
}

/// Computes the vertices that `level` creates from the next coarser level, and collects the rings
/// of the base vertices.
template <PatchMesh Mesh, class Real>
void odd_patches(Mesh& mesh, int level, const OneRing<Real>& rule,
                 RingTable<typename Mesh::Record>& rings, const BeforeFace& before_face = {}) {
  using Record = typename Mesh::Record;
  const Topology topology = mesh.topology();
  const bool ends_only = rule.reads_ends_only();
  mesh.activate(level, level, level);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    for_each_owned(
        patch, level, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
          const PatchFrame frame(patch, side, level, row, column, level);
          const Record& a = frame.coarse_at(-1, 1);
          const Record& b = frame.coarse_at(1, -1);
          frame.at(0, 0) = border || ends_only
                               ? rule.odd_border(a, b)
                               : rule.odd(a, b, frame.coarse_at(-1, -1), frame.coarse_at(1, 1));
        });
    collect_rings(patch, topology, level, rings);
  }
}

/// Moves the vertices that coarser levels created, except base vertices. It reads their new
/// neighbours at `level`. REQUIRES: rule.moves_even().
template <PatchMesh Mesh, class Real>
void even_patches(Mesh& mesh, int level, const OneRing<Real>& rule,
                  const BeforeFace& before_face = {}) {
  using Record = typename Mesh::Record;
  const Topology topology = mesh.topology();
  mesh.activate(level, 1, level - 1);
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    if (before_face) before_face(face);
    const auto patch = mesh.patch(face);
    for (int born = level - 1; patch.size(born) > 1; --born)
      for_each_owned(
          patch, born, [&](auto side, std::int64_t row, std::int64_t column, bool border) {
            const PatchFrame frame(patch, side, born, row, column, level);
            Record& v = frame.at(0, 0);
            v = border ? rule.even_border(v, frame.at(-1, 1), frame.at(1, -1))
                       : rule.even(v, ring_sum(frame.at(1, 0), frame.at(0, 1), frame.at(-1, 1),
                                               frame.at(-1, 0), frame.at(0, -1), frame.at(1, -1)));
          });
  }
}

/// Makes one level of subdivision, including the base vertices.
template <PatchMesh Mesh, class Real>
void refine_patches(Mesh& mesh, int level, const OneRing<Real>& rule) {
  RingTable<typename Mesh::Record> rings(mesh.topology().edges.size());
  odd_patches(mesh, level, rule, rings);
  if (!rule.moves_even()) return;
  even_patches(mesh, level, rule);
  move_base_vertices(mesh.topology(), rings, rule, mesh.base_records());
}

PLAIT_END_NAMESPACE
