// plait/extend/topology.h: which faces, edges and vertices of a base mesh are adjacent, as spans of
// arrays that another object owns (a BaseMesh, or a constexpr array in a test).
//
// Face (a, b, c) is oriented counterclockwise; corners 0, 1, 2 are a, b, c. Side x is opposite
// corner x and runs from corner x+1 to corner x+2 (modulo 3): side 0 is bc, side 1 is ca, side 2 is
// ab.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

using VertexId = std::uint32_t;  ///< input vertex index (unused vertices dropped)
using EdgeId = std::uint32_t;    ///< base edge in layout order: the order of slots on disk
using FaceId = std::uint32_t;    ///< base face in layout order

constexpr std::uint32_t kNoId = 0xffffffffu;

/// The finest level that a mesh can have.
constexpr int kMaxLevel = 20;

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

/// A base edge. An inner edge runs from `start` to `end` in its own face, and `start` has the
/// lower vertex index. The own face of a border edge is its only face.
struct Edge {
  VertexId start = kNoId, end = kNoId;
  FaceSide own, other;  ///< `other` does not exist on a border edge
  constexpr bool is_border() const { return !other.exists(); }
};

/// The connectivity of a base mesh, as spans of arrays that another object owns.
struct Topology {
  std::span<const std::array<VertexId, 3>> faces;
  std::span<const std::array<EdgeId, 3>> face_edges;  ///< [face][side]
  std::span<const Edge> edges;
  /// [vertex] one corner of a face at that vertex. At a border vertex it is the first corner
  /// counterclockwise: the edge from the vertex to the face's next corner is a border edge. At an
  /// inner vertex, the face's next corner is the neighbour with the smallest vertex index. Sums
  /// around a base vertex start at this corner.
  std::span<const FaceSide> vertex_corners;
  std::span<const EdgeId> border_edges;  ///< ascending

  constexpr bool is_own(FaceId face, int side) const {
    return edges[face_edges[face][static_cast<std::size_t>(side)]].own == FaceSide(face, side);
  }
  /// The side of the other face at the same edge. The result does not exist on a border edge.
  constexpr FaceSide across(FaceSide side) const {
    const Edge& edge = edges[face_edges[side.face()][static_cast<std::size_t>(side.side())]];
    // Picks the other one of the two sides without a branch, which processors would predict badly.
    FaceSide beyond;
    beyond.code = edge.own.code ^ edge.other.code ^ side.code;
    return beyond;
  }
  /// The corner at the same vertex in the next face counterclockwise. The result does not exist at
  /// a border.
  constexpr FaceSide next_corner(FaceSide corner) const {
    const FaceSide beyond = across(FaceSide(corner.face(), (corner.side() + 1) % 3));
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
  }
};

PLAIT_END_NAMESPACE
