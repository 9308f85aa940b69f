// backends/compressed/filters/shuffle_filter.h: groups the bytes of components by significance.
#pragma once

#include <cstddef>
#include <memory>

#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Puts the first bytes of all components first, then all second bytes, and so on. Bytes after the
/// last whole component keep their place. REQUIRES: `component_bytes` is 2, 4 or 8.
std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes);

PLAIT_END_NAMESPACE
