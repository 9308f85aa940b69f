// generate/smoothing.h: vertices moved towards the middle of their neighbours.
#pragma once

#include "plait/base_mesh.h"

namespace plait::generation {

/// Every vertex off the border moves by `weight` of the way to the mean of its neighbours, all at
/// once. REQUIRES: an oriented 2-manifold.
void smooth(IndexedMesh& mesh, double weight);

/// `steps` pairs of a shrinking and a slightly larger swelling step: noise goes, volume stays.
/// Source: G. Taubin, "A signal processing approach to fair surface design" (1995).
void taubin_smooth(IndexedMesh& mesh, int steps);

}  // namespace plait::generation
