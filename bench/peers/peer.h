// What plait_bench_loop_peers measures: one way of making a Loop surface in memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/vector3.h"

namespace plait::bench {

using Points = std::vector<Vector3<float>>;

struct Peer {
  std::string name;      ///< library and version
  std::string measured;  ///< what of it is inside the time
  /// Refines `base` to `level` on one thread and returns the thread's seconds of what is measured.
  /// `points`, if given, gets the positions of that level, in any order, outside the time.
  std::function<double(const BaseMesh& base, int level, Points* points)> refine;
};

/// Each is built only where its library is found.
std::vector<Peer> open_subdiv_peers();
std::vector<Peer> cgal_peers();
std::vector<Peer> open_mesh_peers();

}  // namespace plait::bench
