#include "plait/detail/slot_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

SlotShapes::SlotShapes(std::uint64_t edge_count, EdgeSet half, EdgeSet absent)
    : edge_count_(edge_count), half_(std::move(half)), absent_(std::move(absent)) {
  if (const std::uint64_t end = std::max(half_.end(), absent_.end()); end > edge_count)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out slots: expected edges below {}, found half or absent slots up "
                            "to edge {}",
                            edge_count, end - 1));
  if (half_.intersects(absent_))
    throw Error(ErrorCode::kInvalidArgument,
                "lay out slots: expected a slot to be half or absent, found one that is both");
}

PLAIT_END_NAMESPACE
