// sample/area_spread.h: how unequal the small triangles of a base face are.
#pragma once

#include <span>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// A face of the base mesh has a ratio: of the areas of its small triangles, the 99th percentile to
/// the 1st. It is 1 if all are equal.
struct AreaSpread {
  double percentile_90 = 0;   ///< nine of ten faces have at most this ratio
  double share_within_4 = 0;  ///< the share of faces whose ratio is at most 4
};

/// `positions` are those of the samples of `base` at `level`, by SampleNumbers. A small triangle
/// without area gives a ratio of 1e12. All threads of the present arena. Pinned by
/// tests/scans/area_spread_test.cpp.
AreaSpread area_spread(const BaseMesh& base, int level, std::span<const Vector3<double>> positions);

PLAIT_END_NAMESPACE
