// generate/smoothing.h: moves vertices towards the middle of their neighbours.
#pragma once

#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

/// Moves every vertex that is not on the border by `weight` of the way to the mean of its
/// neighbours. All vertices move at the same time. REQUIRES: an oriented 2-manifold.
void smooth(IndexedMesh& mesh, double weight);

/// Does `steps` pairs of steps. The first step of a pair shrinks the surface, the second one
/// expands it slightly more. This removes noise and keeps the volume.
/// Source: G. Taubin, "A signal processing approach to fair surface design" (1995).
void taubin_smooth(IndexedMesh& mesh, int steps);

}  // namespace generation
PLAIT_END_NAMESPACE
