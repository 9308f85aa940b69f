// Distances between two surfaces, as another library measures them.
#pragma once

#include <cstdint>

#include "plait/base_mesh.h"

namespace plait::bench {

struct PeerDistances {
  double rms = 0, mean = 0, percentile_99 = 0, max = 0;  ///< in units of the meshes
};

/// From points spread evenly over `from` to the closest points of `to`. Exists only if CMake found
/// CGAL.
PeerDistances cgal_distances(const IndexedMesh& from, const IndexedMesh& to, std::uint64_t samples);

}  // namespace plait::bench
