// generate/reduce.h: fewer vertices, same surface.
#pragma once

#include <cstdint>

#include "generate/progress.h"
#include "plait/base_mesh.h"

namespace plait::generation {

struct ReduceOptions {
  std::uint64_t vertices = 0;  ///< wanted
  std::uint64_t seed = 0;
  /// 0: short edges go first. Above: squared lengths are multiplied by 1 to 1 + this, at random,
  /// which spreads irregular valences over an evenly triangulated surface.
  double randomness = 0;
};

/// Collapses edges until `mesh` has the wanted number of vertices or none can be collapsed, which
/// the caller sees by the count. Surface topology and borders stay; faces are kept from folding
/// over and valences below 11 as long as other edges are left.
/// REQUIRES: an oriented 2-manifold whose vertices are all used.
IndexedMesh reduce(IndexedMesh mesh, const ReduceOptions& options, const Progress& progress);

}  // namespace plait::generation
