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
/// level, and each has a quarter of the triangles of the one before. Memory beside the result: 12
/// bytes for each face of `mesh`, and 21 for each face of the next level.
/// Pinned by tests/engine/mesh/recovery_test.cpp.
RecoveredLevels recover_levels(const FinestMesh& mesh, int most_levels,
                               const std::function<void(int)>& told = {});

/// Writes the vertices of the patch whose corner 0 is `corner` to `vertices`, in row order
/// (plait/reader.h). REQUIRES: 4^levels faces from this corner on are a patch.
void walk_patch(const FinestMesh& mesh, FaceSide corner, int levels, VertexId* vertices);

PLAIT_END_NAMESPACE
