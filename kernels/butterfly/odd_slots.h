// The modified Butterfly scheme over the edge grids of a sweep.
#pragma once

#include <cstdint>
#include <span>

#include "butterfly/halo.h"
#include "butterfly/rings.h"
#include "butterfly/stencils.h"
#include "plait/detail/gather_grid.h"
#include "plait/detail/numbers.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"
#include "schemes/butterfly.h"

namespace plait::butterfly {

/// The neighbour of the border vertex `vertex` along the border, on the border edge that is not
/// `edge`.
template <class Real>
Vector3<Real> along_border(const Topology& mesh, const RingTable<Vector3<Real>>& rings,
                           VertexId vertex, EdgeId edge) {
  EdgeId first = kNoId, last = kNoId;
  for_each_spoke(mesh, vertex, [&](EdgeId spoke) {
    if (first == kNoId) first = spoke;
    last = spoke;
  });
  return rings.next_to(mesh, first == edge ? last : first, vertex);
}

/// Computes the slot at level grid.level() + 1. `coarse` and `extraordinary` have the rings at
/// grid.level(). REQUIRES: the halo of `grid` is filled.
template <class Real>
void odd_slot(const Topology& mesh, const RingTable<Vector3<Real>>& coarse,
              const ExtraordinaryRings<Real>& extraordinary, EdgeId edge,
              const EdgeGrid<Vector3<Real>>& grid,
              const SlotRecords<Vector3<Real>>& slot) noexcept {
  const std::int64_t n = grid.size();
  const VertexId start = mesh.edges[edge].start, end = mesh.edges[edge].end;
  const bool border = mesh.edges[edge].is_border();
  Vector3<Real>* next = slot.data();
  for (std::int64_t row = 0; row < n; ++row) {
    const std::int64_t columns = row_records(slot.shape, n, row);
    for (std::int64_t column = 0; column < columns; ++column) {
      const Vector3<Real>& a = *grid.at(row, column + 1);
      const Vector3<Real>& b = *grid.at(row + 1, column);
      // At (0, n-1) of the slot, A is the end of the edge. At (n-1, 0), B is its start.
      const bool at_end = row == 0 && column == n - 1, at_start = row == n - 1 && column == 0;
      Vector3<Real>& to = *next++;
      if (border && row + column == n - 1) {
        const Vector3<Real> before =
            at_end ? along_border(mesh, coarse, end, edge) : *grid.at(row - 1, column + 2);
        const Vector3<Real> after =
            at_start ? along_border(mesh, coarse, start, edge) : *grid.at(row + 2, column - 1);
        to = odd_border(before, a, b, after);
        continue;
      }
      const bool odd_end = at_end && extraordinary.contains(end);
      const bool odd_start = at_start && extraordinary.contains(start);
      if (odd_end || odd_start) {
        to = extraordinary.odd(edge, odd_start, odd_end);
        continue;
      }
      to = odd(a, b, *grid.at(row, column), *grid.at(row + 1, column + 1),
               *grid.at(row - 1, column + 1), *grid.at(row + 2, column),
               *grid.at(row + 1, column - 1), *grid.at(row, column + 2));
    }
  }
}

}  // namespace plait::butterfly

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Computes the new vertices of one level, edge by edge. The object copies `rings`, the rings of
/// the coarser level, so the caller may replace them by finer ones during the pass.
template <class Real>
auto odd_slots(const Butterfly<Real>&, const Topology& mesh, const RingTable<Vector3<Real>>& rings,
               std::span<const Vector3<Real>> base) {
  return
      [mesh, coarse = rings, extraordinary = butterfly::ExtraordinaryRings<Real>(mesh, rings, base),
       base](const SlotSource<Vector3<Real>>& source, EdgeId edge, EdgeGrid<Vector3<Real>>& grid,
             const SlotRecords<Vector3<Real>>& slot) {
        butterfly::fill_halo(mesh, source, base, edge, grid);
        butterfly::odd_slot(mesh, coarse, extraordinary, edge, grid, slot);
      };
}

PLAIT_END_NAMESPACE
