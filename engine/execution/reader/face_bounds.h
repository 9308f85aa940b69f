// Computes the bounds of the patches of all faces, from the records of all levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "format/bounds_file.h"
#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/level_file.h"
#include "plait/extend/session.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Reads each block of `levels` once, in file order. `base` has the records of the base vertices.
/// `progress` counts bytes of levels. REQUIRES: holds_points(schema). Errors: kCancelled; those of
/// Session::pin.
std::vector<FaceBounds> compute_face_bounds(const BaseMesh& mesh, const AttributeSchema& schema,
                                            std::span<const std::byte> base,
                                            std::span<const LevelFile* const> levels,
                                            Session& session, const ProgressCallback& progress);

PLAIT_END_NAMESPACE
