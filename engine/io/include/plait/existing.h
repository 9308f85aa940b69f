// plait/existing.h: whether a new output may have a name that is taken.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class Existing : std::uint8_t {
  kRefuse,   ///< an existing output stays, and is an error
  kReplace,  ///< the new output replaces an existing one, when the new output is complete
};

PLAIT_END_NAMESPACE
