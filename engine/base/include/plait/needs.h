// plait/needs.h: the memory that a pass, a visit or a subdivision needs.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Bytes, before the work begins.
struct Needs {
  std::uint64_t frames = 0;    ///< of the pager's budget: the smallest budget for the work
  std::uint64_t resident = 0;  ///< in addition to the budget
};

PLAIT_END_NAMESPACE
