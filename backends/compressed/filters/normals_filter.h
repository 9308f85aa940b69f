// backends/compressed/filters/normals_filter.h: predicts the normals of a block from positions.
// docs/filters/normals.md describes it byte for byte.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Options: the name of the attribute with the positions; "position" without options. Errors:
/// kNotSupported for records other than three float32, and if the store has no such attribute of
/// three float32 or float64 with the levels up to that of the block.
std::unique_ptr<Filter> make_normals_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
