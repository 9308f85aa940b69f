// plait/detail/ring_table.h: the one-ring of every base vertex at one level, in memory. The table
// has, for each edge, the vertex next to its start and the vertex next to its end. A rule at a base
// vertex reads only its ring. So the table replaces pins on the slots of all edges around a base
// vertex, whose number has no limit.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The rings of all base vertices at one level, in memory: two records for each base edge.
template <class Record>
class RingTable {
 public:
  explicit RingTable(std::uint64_t edge_count) : spokes_(edge_count) {}

  /// Fills the table for the base mesh itself, where the neighbours of base vertices are base
  /// vertices.
  void set_from_base(const Topology& mesh, std::span<const Record> base) {
    for (std::size_t edge = 0; edge < spokes_.size(); ++edge)
      spokes_[edge] = {base[mesh.edges[edge].end], base[mesh.edges[edge].start]};
  }
  /// Several threads may set different edges.
  void set(EdgeId edge, const Record& next_to_start, const Record& next_to_end) noexcept {
    spokes_[edge] = {next_to_start, next_to_end};
  }

  /// The vertex next to `vertex` on `edge`. REQUIRES: `vertex` is an end of `edge`.
  const Record& next_to(const Topology& mesh, EdgeId edge, VertexId vertex) const {
    return spokes_[edge][mesh.edges[edge].end == vertex];
  }

 private:
  std::vector<std::array<Record, 2>> spokes_;
};

/// Calls visit(EdgeId spoke) for each edge at a base vertex, counterclockwise. It starts at the
/// first border edge, or, at an inner vertex, at the edge to the neighbour with the smallest index.
/// Returns the valence.
template <class Visit>
int for_each_spoke(const Topology& mesh, VertexId vertex, Visit visit) {
  const FaceSide first = mesh.vertex_corners[vertex];
  int valence = 0;
  FaceSide corner = first;
  do {
    visit(mesh.face_edges[corner.face()][static_cast<std::size_t>((corner.side() + 2) % 3)]);
    ++valence;
    const FaceSide next = mesh.next_corner(corner);
    if (!next.exists()) {
      visit(mesh.face_edges[corner.face()][static_cast<std::size_t>((corner.side() + 1) % 3)]);
      return valence + 1;
    }
    corner = next;
  } while (corner != first);
  return valence;
}

/// Whether a base vertex lies on the border.
inline bool is_border_vertex(const Topology& mesh, VertexId vertex) {
  const FaceSide corner = mesh.vertex_corners[vertex];
  return mesh
      .edges[mesh.face_edges[corner.face()][static_cast<std::size_t>((corner.side() + 2) % 3)]]
      .is_border();
}

PLAIT_END_NAMESPACE
