#include "prune/balance.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t balance_depths(const Topology& mesh, int most, std::vector<std::uint8_t>& depths) {
  if (most == 0 || depths.empty()) return 0;
  const std::vector<std::uint8_t> before = depths;
  // The deepest faces first: what makes a face deeper is then final.
  for (int depth = *std::ranges::max_element(depths); depth > most; --depth)
    for (FaceId face = 0; face < depths.size(); ++face) {
      if (depths[face] != depth) continue;
      for (int side = 0; side < 3; ++side) {
        const FaceSide beyond = mesh.across(FaceSide(face, side));
        if (!beyond.exists()) continue;
        std::uint8_t& other = depths[beyond.face()];
        other = std::max(other, static_cast<std::uint8_t>(depth - most));
      }
    }
  std::uint64_t raised = 0;
  for (std::size_t face = 0; face < depths.size(); ++face)
    raised += depths[face] != before[face] ? 1u : 0u;
  return raised;
}

PLAIT_END_NAMESPACE
