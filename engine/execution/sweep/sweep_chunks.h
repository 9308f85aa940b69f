// How many edges a sweep works on between two moves of its window.
#pragma once

#include <algorithm>

#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr int kMostChunkEdgesLog2 = 12;

/// The number of slots in a block of the finest level, but enough edges for every thread, and not
/// so many that the window grows. `fewest_slots_log2` belongs to the level with the fewest slots in
/// a block.
inline EdgeId chunk_edges(int fewest_slots_log2, int threads) {
  constexpr EdgeId kMinEdgesPerThread = 8;
  EdgeId wanted = 1;
  while (wanted < kMinEdgesPerThread * static_cast<EdgeId>(threads)) wanted *= 2;
  return std::max(EdgeId{1} << std::min(fewest_slots_log2, kMostChunkEdgesLog2), wanted);
}

PLAIT_END_NAMESPACE
