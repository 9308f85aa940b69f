// sample/folds.h: edges of small triangles that are folded.
#pragma once

#include <cstdint>
#include <span>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// How many edges between small triangles of `base` at `level` are folded, as is_folded() of
/// surface/repair.h says. `positions` are those of the samples, by SampleNumbers. All threads of
/// the present arena. Pinned by tests/scans/turned_test.cpp.
std::uint64_t count_folds(const BaseMesh& base, int level, std::span<const Point> positions);

PLAIT_END_NAMESPACE
