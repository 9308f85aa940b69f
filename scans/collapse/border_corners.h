// collapse/border_corners.h: the corners of the borders of drawn surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// [vertex] 1 where a border turns by more than 30 degrees. A border that a scanner left is jagged:
/// it turns by all angles. So a border has corners only if at most a quarter as many of its
/// vertices turn by 15 to 30 degrees, and at most a quarter of all turn by more than 30. Pinned by
/// tests/scans/decimate_test.cpp.
std::vector<std::uint8_t> border_corners(const Surface& surface);

PLAIT_END_NAMESPACE
