// The normals of stored positions, computed when they are read.
#pragma once

#include <memory>

#include "plait/derivation.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// REQUIRES: the source has 3 float32 or 3 float64. Its finest level gives the neighbours of every
/// vertex, as in subdivide() and displace().
std::unique_ptr<Deriver> make_normals_of_positions(DerivationSource source);

PLAIT_END_NAMESPACE
