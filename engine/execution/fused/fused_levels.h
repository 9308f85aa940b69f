// The number of levels that a fused pass makes. The sizes of its buffers depend on this number.
#pragma once

#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline int fused_levels(const Store& store, const FusedPass& pass) {
  return relative_to_base(pass.finest_level, store.base_level()).refinements;
}

PLAIT_END_NAMESPACE
