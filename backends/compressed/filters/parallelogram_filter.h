// backends/compressed/filters/parallelogram_filter.h: differences from a prediction that continues
// the surface inside a slot. docs/filters/parallelogram.md has the bytes.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backends/pipeline.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// `level.geometry` may be null; then the filter is not used. Errors: kNotSupported unless the
/// components are float32 or float64.
std::unique_ptr<Filter> make_parallelogram_filter(std::string_view options,
                                                  const FilterLevel& level);

PLAIT_END_NAMESPACE
