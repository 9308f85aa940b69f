// Points along the sides of a patch, and the steps from one corner towards another.
#pragma once

#include <cstdint>

#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The point of `side` with this weight at its start.
constexpr FaceIndex on_side(int level, int side, std::int64_t weight) {
  std::int64_t k[3] = {};
  k[(side + 1) % 3] = weight;
  k[(side + 2) % 3] = (std::int64_t{1} << level) - weight;
  return {0, level, k[1], k[2]};
}

struct LatticeStep {
  std::int64_t i, j;
};
/// The step that moves one unit of weight to corner `to` from corner `from`.
constexpr LatticeStep step(int to, int from) {
  return {std::int64_t(to == 1) - std::int64_t(from == 1),
          std::int64_t(to == 2) - std::int64_t(from == 2)};
}

PLAIT_END_NAMESPACE
