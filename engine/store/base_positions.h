// engine/store/base_positions.h: which positions a store can have.
#pragma once

#include "plait/attribute.h"
#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Throws kInvalidArgument unless positions can have this type, float32 or float64, and if one of
/// the mesh is too large for it.
void check_positions(const BaseMesh& mesh, ComponentType precision);

PLAIT_END_NAMESPACE
