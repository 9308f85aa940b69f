// backends/compressed/filters/byte_delta_filter.h: differences of bytes that follow each other in a
// plane of the shuffle filter. docs/filters/bytedelta.md has the bytes.
#pragma once

#include <memory>
#include <string_view>

#include "plait/backends/pipeline.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The filter after `shuffle`: every byte of a plane minus the byte of the record before it, same
/// component and same plane.
std::unique_ptr<Filter> make_byte_delta_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
