// How many edges a sweep works at between two moves of its window.
#pragma once

#include <algorithm>

#include "plait/topology.h"

namespace plait {

constexpr int kMostChunkEdgesLog2 = 12;

/// As many as a block of the finest level has slots, within limits: enough for every thread, and
/// not so many that the window grows. `fewest_slots_log2` is of the level with the fewest.
inline EdgeId chunk_edges(int fewest_slots_log2, int threads) {
  constexpr EdgeId kMinEdgesPerThread = 8;
  EdgeId wanted = 1;
  while (wanted < kMinEdgesPerThread * static_cast<EdgeId>(threads)) wanted *= 2;
  return std::max(EdgeId{1} << std::min(fewest_slots_log2, kMostChunkEdgesLog2), wanted);
}

}  // namespace plait
