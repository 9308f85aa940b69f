// backends/compressed/filters/columns_filter.h: differences from straight lines down the columns of
// a slot. docs/filters/columns.md has the bytes.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// `level.geometry` may be null; then the filter is not used. Errors: kNotSupported unless the
/// components are float32 or float64.
std::unique_ptr<Filter> make_columns_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
