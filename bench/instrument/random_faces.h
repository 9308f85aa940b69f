// bench/instrument/random_faces.h: the faces whose patches a measurement reads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::instrument {

/// Faces in the order of requests: all equally likely, or (Zipf) the n-th of them has a weight of
/// 1/n. Only the seed and the counts decide.
inline std::vector<FaceId> draw_faces(bool zipf, std::uint64_t faces, std::size_t count,
                                      std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> sums;
  if (zipf)
    for (std::uint64_t rank = 1; rank <= faces; ++rank)
      sums.push_back((sums.empty() ? 0 : sums.back()) + 1 / static_cast<double>(rank));
  std::vector<FaceId> drawn;
  while (drawn.size() < count) {
    std::uint64_t face = random();
    if (zipf) {
      const double at = static_cast<double>(face >> 11) * 0x1p-53 * sums.back();
      // Popular faces are scattered over the store.
      face = static_cast<std::uint64_t>(std::ranges::lower_bound(sums, at) - sums.begin()) *
             2654435761u;
    }
    drawn.push_back(static_cast<FaceId>(face % faces));
  }
  return drawn;
}

}  // namespace plait::instrument
