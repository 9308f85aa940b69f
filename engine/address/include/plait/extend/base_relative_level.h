// plait/extend/base_relative_level.h: the two ways to count levels, and the only functions that
// convert between them.
//
// A level number of a store, in every call, message and page, is a plain int and counts from the
// mesh that the user gave. The base mesh of a store may be that mesh refined a few times already
// (Store::base_level()). Sizes of grids and slots follow from how often the *base mesh* is refined:
// such a count is a BaseRelativeLevel. Its constructor is explicit, so a plain int cannot become
// one by accident.
#pragma once

#include <compare>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// How often the base mesh is refined to reach a level: 0 for the base mesh itself.
struct BaseRelativeLevel {
  int refinements = 0;

  constexpr BaseRelativeLevel() = default;
  explicit constexpr BaseRelativeLevel(int times) : refinements(times) {}
  friend constexpr auto operator<=>(BaseRelativeLevel, BaseRelativeLevel) = default;
};

/// `level` of a store whose base mesh is at `base_level`.
constexpr BaseRelativeLevel relative_to_base(int level, int base_level) {
  return BaseRelativeLevel(level - base_level);
}
/// The inverse of relative_to_base().
constexpr int level_number(BaseRelativeLevel level, int base_level) {
  return level.refinements + base_level;
}

PLAIT_END_NAMESPACE
