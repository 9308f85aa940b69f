// backends/compressed/filters/hierarchy_filter.h: predicts the vertices of a block from the coarser
// levels. docs/filters/hierarchy.md describes it byte for byte.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Options: "butterfly" or nothing, and "midpoint" (compressed/filters/edge_lattice.h), each with
/// or without "step=STEP" for rounded numbers (compressed/filters/lattice_filter.h). Errors:
/// kInvalidArgument for others; kNotSupported for records other than 1 to 4 float32 or float64.
std::unique_ptr<Filter> make_hierarchy_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
