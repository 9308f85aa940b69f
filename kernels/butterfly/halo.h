// One row of vertices beyond the four outer edges of a grid, where the wings of Butterfly
// stencils lie: taken from the face there, or continued in the plane of the inner triangle where
// the outer edge is a border.
#pragma once

#include <cstdint>
#include <span>

#include "butterfly/stencils.h"
#include "edge_grid/gather.h"
#include "plait/edge_index.h"

namespace plait::butterfly {

/// A single vertex, wherever it is stored.
template <class Record>
const Record& fetch(const Topology& mesh, const SlotSource<Record>& source,
                    std::span<const Record> base, const FaceIndex& point) {
  if (is_corner(point.level, point.i, point.j))
    return base[mesh.faces[point.face][static_cast<std::size_t>(corner_of(point.i, point.j))]];
  const EdgeIndex at = edge_index(mesh, point);
  const bool border = mesh.edges[at.edge].is_border();
  return source.slot(
      at.level,
      at.edge)[static_cast<std::size_t>(slot_position(at.level, border, at.row, at.column))];
}

/// Fills points (-1, q) and (p, -1), 1 <= p, q <= N, of the edge's own face, and the same of
/// the other face, turned. REQUIRES: the inside of the grid is there.
template <class Record>
void fill_halo(const Topology& mesh, const SlotSource<Record>& source, std::span<const Record> base,
               EdgeId edge, EdgeGrid<Record>& grid) {
  const std::int64_t size = grid.size();
  for (const bool turned : {false, true}) {
    const FaceSide side = turned ? mesh.edges[edge].other : mesh.edges[edge].own;
    if (!side.exists()) continue;
    const auto place = [&](std::int64_t p, std::int64_t q) -> Record& {
      return turned ? *grid.at(size - p, size - q) : *grid.at(p, q);
    };
    const int start = (side.side() + 1) % 3, end = (side.side() + 2) % 3;
    for (const bool beyond_start : {true, false}) {
      // Where the start's weight p vanishes is the side opposite the start; likewise for the end.
      const int outer = beyond_start ? start : end;
      const bool open = !mesh.across(FaceSide(side.face(), outer)).exists();
      for (std::int64_t k = 1; k <= size; ++k) {
        const std::int64_t p = beyond_start ? -1 : k, q = beyond_start ? k : -1;
        if (open) {
          place(p, q) = beyond_start ? continued(place(0, k), place(0, k - 1), place(1, k - 1))
                                     : continued(place(k, 0), place(k - 1, 0), place(k - 1, 1));
          continue;
        }
        std::int64_t weight[3] = {};
        weight[start] = p;
        weight[end] = q;
        weight[side.side()] = size - p - q;
        const FaceIndex beyond =
            unfold(mesh, {side.face(), grid.level(), weight[1], weight[2]}, outer);
        place(p, q) = fetch(mesh, source, base, beyond);
      }
    }
  }
}

}  // namespace plait::butterfly
