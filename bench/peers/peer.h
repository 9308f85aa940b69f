// One way of computing a Loop surface in memory, which plait_bench_loop_peers measures.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/vector3.h"

namespace plait::bench {

using Points = std::vector<Vector3<float>>;

struct Peer {
  std::string name;      ///< library and version
  std::string measured;  ///< the part that is measured
  /// Refines `base` to `level` on one thread. Returns the processor time in seconds of the measured
  /// part. If `points` is not null, it gets the positions of that level, in any order; copying them
  /// is not measured.
  std::function<double(const BaseMesh& base, int level, Points* points)> refine;
};

/// Each function exists only if CMake found its library.
std::vector<Peer> open_subdiv_peers();
std::vector<Peer> cgal_peers();
std::vector<Peer> open_mesh_peers();

}  // namespace plait::bench
