// generate/reduce.h: reduces the number of vertices of a surface.
#pragma once

#include <cstdint>

#include "generate/progress.h"
#include "plait/base_mesh.h"

PLAIT_BEGIN_NAMESPACE
namespace generation {

struct ReduceOptions {
  std::uint64_t vertices = 0;  ///< wanted
  std::uint64_t seed = 0;
  /// 0: short edges are collapsed first. Above 0: each squared length is multiplied by a random
  /// number between 1 and 1 + randomness. This spreads irregular valences over an evenly
  /// triangulated surface.
  double randomness = 0;
};

/// Collapses edges until `mesh` has the wanted number of vertices, or until no edge can be
/// collapsed; then the result has more vertices. Topology and borders of the surface do not change.
/// As long as other edges are left, no face folds over and valences stay below 11.
/// REQUIRES: an oriented 2-manifold whose vertices are all used.
IndexedMesh reduce(IndexedMesh mesh, const ReduceOptions& options, const Progress& progress);

}  // namespace generation
PLAIT_END_NAMESPACE
