// Computes the bounds of the patches of all faces, from the records of all levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "plait/attribute.h"
#include "plait/level_file.h"
#include "plait/session.h"
#include "plait/topology.h"
#include "store/bounds_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether an attribute has positions in space: float32 x 3 or float64 x 3.
bool has_positions(const AttributeSchema& schema);

/// Told of the bytes of levels that are read, and of those of all levels. False cancels.
using BoundsProgress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

/// Reads each block of `levels` once, in file order. `base` has the records of the base vertices.
/// `proceed` may be empty. REQUIRES: has_positions(schema). Errors: kCancelled; those of
/// Session::pin.
std::vector<FaceBounds> compute_face_bounds(const Topology& mesh, const AttributeSchema& schema,
                                            std::span<const std::byte> base,
                                            std::span<const LevelFile* const> levels,
                                            Session& session, const BoundsProgress& proceed);

PLAIT_END_NAMESPACE
