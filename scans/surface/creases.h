// surface/creases.h: the sharp edges of a surface, and where they end, meet or turn.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

struct Creases {
  double angle = 180;  ///< degrees between the normals of two faces: larger ones are sharp
  /// [3 face + side] 1: the edge is sharp. Both sides of it are marked. Empty: no edge is.
  std::vector<std::uint8_t> sides;
  /// [vertex] 1: other than two sharp edges are there, or a border, or they turn by more than 45
  /// degrees. Empty: none.
  std::vector<std::uint8_t> corners;
  std::uint64_t edge_count = 0, corner_count = 0;
};

/// The edges that turn by more than `angle` degrees; 180: none. Not set: the largest of 60, 50, 40
/// and 30 that the surface has a gap at: at most an eighth as many edges turn by half of it or
/// more, up to it, as turn further, at most half of all turn further, and at most a third as many
/// corners are left as creases. Noise and rounded surfaces turn by all angles, so they have none.
/// Pinned by tests/scans/creases_test.cpp.
Creases find_creases(const Surface& surface, std::optional<double> angle);

/// The surface with a border along each crease: its faces keep their numbers and corners, so its
/// points stay what they are. A vertex is there once for each part of the surface that it joins.
Surface cut_at(const Surface& surface, const Creases& creases);

PLAIT_END_NAMESPACE
