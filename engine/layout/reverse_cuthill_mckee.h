// layout/reverse_cuthill_mckee.h: an order of the faces in which adjacent ones are near each other.
#pragma once

#include <vector>

#include "plait/extend/topology.h"

namespace plait::layout {

/// The faces in reverse Cuthill-McKee order of their adjacency across edges, order[new] = old.
/// Every component starts from a face at one of its ends. O(F): a few searches per component.
/// Deterministic.
/// Sources: E. Cuthill, J. McKee, "Reducing the bandwidth of sparse symmetric matrices" (1969);
/// A. George, J. Liu, "An implementation of a pseudoperipheral node finder" (1979).
std::vector<FaceId> reverse_cuthill_mckee(const Topology& topology);

}  // namespace plait::layout
