// conversion/uniform_levels.h: fills the levels that faces with depths of their own do not have.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Copies all attributes, face attributes and texts of `from` into `to`, which was created with the
/// same base mesh without depths and has no attribute. A vertex that no face of `from` has lies in
/// the middle between its two parents (the midpoint rule): each number is the mean, of integers
/// rounded down; normals (`normal`, three floats) get length 1 again. All others keep their bits.
/// The copy has no scheme, because none makes these vertices, and no record of an earlier rounding,
/// because they are not rounded. Leaves the commit to the caller.
/// Memory: the budgets of the two stores, and one patch of the finest level. `progress` counts
/// patches. Errors: kCancelled; those of Reader and PatchWriter; kOutOfMemory. Pinned by
/// tests/jobs/uniform_levels_test.cpp.
void fill_levels(const Store& from, Store& to, const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
