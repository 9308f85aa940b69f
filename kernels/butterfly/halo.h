// Fills one row of vertices beyond the four outer edges of a grid. The wings of Butterfly stencils
// read them. They come from the face beyond the outer edge. If that edge is a border, they continue
// the plane of the inner triangle.
#pragma once

#include <cstdint>
#include <span>

#include "butterfly/stencils.h"
#include "plait/detail/gather_grid.h"
#include "plait/extend/edge_index.h"

namespace plait::butterfly {

/// Reads a single vertex at any place.
template <class Record>
const Record& fetch(const Topology& mesh, const SlotSource<Record>& source,
                    std::span<const Record> base, const FaceIndex& point) {
  if (is_corner(point.level, point.i, point.j))
    return base[mesh.faces[point.face][static_cast<std::size_t>(corner_of(point.i, point.j))]];
  const EdgeIndex at = edge_index(mesh, point);
  return source.slot(at.level, at.edge).at(at.level, at.row, at.column);
}

/// Fills the points (-1, q) and (p, -1), 1 <= p, q <= N, beyond the edge's own face, and the same
/// points of the other face in its rotated frame. REQUIRES: the rest of the grid is filled.
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
      // The weight p of the start is 0 on the side opposite the start, and q on the side opposite
      // the end.
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
