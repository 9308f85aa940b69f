// bench/peers/peer.h: other libraries that compute what plait computes. Each function exists only
// if CMake found its library.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/vector3.h"

namespace plait::bench {

using Points = std::vector<Vector3<float>>;

/// One way of computing a Loop surface in memory, which plait_bench_loop_peers measures.
struct Peer {
  std::string name;      ///< library and version
  std::string measured;  ///< the part that is measured
  /// Refines `base` to `level` on one thread. Returns the processor time in seconds of the measured
  /// part. If `points` is not null, it gets the positions of that level, in any order; copying them
  /// is not measured.
  std::function<double(const BaseMesh& base, int level, Points* points)> refine;
};

std::vector<Peer> open_subdiv_peers();
std::vector<Peer> cgal_peers();
std::vector<Peer> open_mesh_peers();

/// The distances of points spread evenly over `from` to the closest points of `to`.
std::vector<double> cgal_distances(const IndexedMesh& from, const IndexedMesh& to,
                                   std::uint64_t samples);

}  // namespace plait::bench
