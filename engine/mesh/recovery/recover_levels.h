// Finds the base mesh of a mesh that was refined by splitting each triangle into four, and where
// the patches of its faces lie in the fine mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mesh/recovery/level_mesh.h"
#include "mesh/recovery/triangle_roles.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct RecoveredLevels {
  std::vector<LevelMesh> meshes;  ///< one for each level that was found; the base mesh is the last
  bool had_choice = false;        ///< another base mesh would have done as well
  /// Why there is no further level; nothing if no further one was wanted.
  std::optional<RecoveryFailure> failure;
};

/// At most `most_levels`. Calls told(levels) when it has found another level. O(V + F) for each
/// level, and each has a quarter of the triangles of the one before. Memory beside the result: 10
/// bytes for each face of `mesh`.
/// Pinned by tests/engine/mesh/recovery_test.cpp.
RecoveredLevels recover_levels(const FinestMesh& mesh, int most_levels,
                               const std::function<void(int)>& told = {});

/// Writes the vertices of the patches whose corners 0 are `corners` to `vertices`, one patch after
/// another, each in row order (plait/reader.h). Many patches at once are faster than one after
/// another. REQUIRES: 4^levels faces from each corner on are a patch.
void walk_patches(const FinestMesh& mesh, std::span<const FaceSide> corners, int levels,
                  VertexId* vertices);

PLAIT_END_NAMESPACE
