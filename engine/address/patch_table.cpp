#include "plait/detail/patch_table.h"

#include <fmt/format.h>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void PatchTable::check(int level, std::int64_t i, std::int64_t j) const {
  if (!has(level))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("face {}, level {}: expected an active level, {} to {}", face_, level,
                            base_level_, level_number(finest_, base_level_)));
  const std::int64_t size = this->size(level);
  // No stencil reaches further than two faces.
  if (i < -size || j < -size || i > 2 * size || j > 2 * size || i + j > 2 * size)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("face {}, level {}: expected a point in or near the grid of size {}, "
                            "found ({}, {}); the base mesh is at level {}",
                            face_, level, size, i, j, base_level_));
}

void PatchTable::refuse_beyond_border(int level, std::int64_t i, std::int64_t j) const {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("face {}, level {}: the point ({}, {}) lies beyond a border", face_,
                          level, i, j));
}

PLAIT_END_NAMESPACE
