// engine/store/base_positions.h: which positions a store can have, and which a work takes.
#pragma once

#include <string_view>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Throws kInvalidArgument unless positions can have this type, float32 or float64, and if one of
/// the mesh is too large for it.
void check_positions(const BaseMesh& mesh, ComponentType precision);

/// Throws kInvalidArgument unless records of the attribute are points: float32 x 3 or float64 x 3.
/// `what` begins the message.
void check_points(const AttributeSchema& schema, std::string_view what);
/// Attribute "position" of the store. Errors: kNotFound; those of check_points(). `verb` and the
/// store begin the message.
AttributeId position_of(const Store& store, std::string_view verb);

PLAIT_END_NAMESPACE
