// plait/topology.h: how the faces, edges and vertices of a base mesh hang together, as spans that
// somebody else owns (BaseMesh, or a constexpr array in a test).
//
// Face (a, b, c) is oriented counterclockwise; corners 0, 1, 2 are a, b, c. Side x is the one
// opposite corner x and runs from corner x+1 to corner x+2 (modulo 3): side 0 is bc, 1 ca, 2 ab.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace plait {

using VertexId = std::uint32_t;  ///< input vertex index (unused vertices dropped)
using EdgeId = std::uint32_t;    ///< base edge in layout order: the order of slots on disk
using FaceId = std::uint32_t;    ///< base face in layout order

constexpr std::uint32_t kNoId = 0xffffffffu;

/// One side, or one corner, of one face.
struct FaceSide {
  std::uint32_t code = kNoId;

  constexpr FaceSide() = default;
  constexpr FaceSide(FaceId face, int side) : code(3 * face + static_cast<std::uint32_t>(side)) {}
  constexpr bool exists() const { return code != kNoId; }
  constexpr FaceId face() const { return code / 3; }
  constexpr int side() const { return static_cast<int>(code % 3); }
  friend constexpr bool operator==(FaceSide, FaceSide) = default;
};

/// A base edge. It runs start -> end in its own face: the face in which that is from the lower to
/// the higher vertex index, or for a border edge the only face there is.
struct Edge {
  VertexId start = kNoId, end = kNoId;
  FaceSide own, other;  ///< `other` does not exist on a border edge
  constexpr bool is_border() const { return !other.exists(); }
};

struct Topology {
  std::span<const std::array<VertexId, 3>> faces;
  std::span<const std::array<EdgeId, 3>> face_edges;  ///< [face][side]
  std::span<const Edge> edges;
  /// [vertex] one corner at that vertex: on a border vertex the first one counterclockwise (its
  /// spoke to the next corner is a border edge), else the one whose next corner is the neighbour
  /// of smallest vertex index. Sums around a base vertex start here.
  std::span<const FaceSide> vertex_corners;
  std::span<const EdgeId> border_edges;  ///< ascending

  constexpr bool is_own(FaceId face, int side) const {
    return edges[face_edges[face][static_cast<std::size_t>(side)]].own == FaceSide(face, side);
  }
  /// The same edge seen from the face beyond it; does not exist on a border.
  constexpr FaceSide across(FaceSide side) const {
    const Edge& edge = edges[face_edges[side.face()][static_cast<std::size_t>(side.side())]];
    // Of two sides the other one, without a branch that no processor foresees.
    FaceSide beyond;
    beyond.code = edge.own.code ^ edge.other.code ^ side.code;
    return beyond;
  }
  /// The corner at the same vertex in the next face counterclockwise; does not exist at a border.
  constexpr FaceSide next_corner(FaceSide corner) const {
    const FaceSide beyond = across(FaceSide(corner.face(), (corner.side() + 1) % 3));
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
  }
};

}  // namespace plait
