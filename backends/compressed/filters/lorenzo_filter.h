// backends/compressed/filters/lorenzo_filter.h: differences inside a slot, along its rows and
// across them. docs/filters/lorenzo.md has the bytes.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backends/pipeline.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For components of every type. `level.geometry` may be null; then the filter is not used.
std::unique_ptr<Filter> make_lorenzo_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
