// surface/edge_pairs.h: which sides of faces are the same edge, which faces hang together, and the
// borders.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Sets `across` for each edge of exactly two sides, whatever their directions. The sides of other
/// edges are borders. Returns how many edges have more than two sides. REQUIRES: no face has a
/// vertex twice.
std::uint64_t pair_sides(std::size_t vertices, std::span<const std::array<VertexId, 3>> faces,
                         std::vector<FaceSide>& across);

/// Sets `component` of each face, and returns how many faces each component has.
std::vector<std::uint64_t> face_components(std::size_t faces, std::span<const FaceSide> across,
                                           std::vector<std::uint32_t>& component);

/// The side that follows a border side on its border, in the direction of the sides.
inline FaceSide next_of_border(std::span<const FaceSide> across, FaceSide side) {
  // Around the end of the side, to the other border of its fan.
  FaceSide next(side.face(), (side.side() + 1) % 3);
  while (across[next.code].exists()) {
    const FaceSide beyond = across[next.code];
    next = FaceSide(beyond.face(), (beyond.side() + 1) % 3);
  }
  return next;
}

/// Calls work(sides) for each border, with its sides in their order. REQUIRES: an oriented
/// 2-manifold.
template <class Work>
void for_each_border(std::size_t faces, std::span<const FaceSide> across, Work&& work) {
  std::vector<bool> seen(3 * faces);
  std::vector<FaceSide> sides;
  for (FaceId face = 0; face < faces; ++face)
    for (int at = 0; at < 3; ++at) {
      const FaceSide first(face, at);
      if (across[first.code].exists() || seen[first.code]) continue;
      sides.clear();
      for (FaceSide side = first; !seen[side.code]; side = next_of_border(across, side)) {
        seen[side.code] = true;
        sides.push_back(side);
      }
      work(sides);
    }
}

PLAIT_END_NAMESPACE
