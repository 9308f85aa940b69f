// How many levels a fused pass makes, which sizes all that it works with.
#pragma once

#include "plait/base_relative_level.h"
#include "plait/fused.h"
#include "plait/store.h"

namespace plait {

inline int fused_levels(const Store& store, const FusedPass& pass) {
  return relative_to_base(pass.finest_level, store.base_level()).refinements;
}

}  // namespace plait
