#include "plait/extend/level_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "plait/error.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The limit is less than the largest file offset (offsets are signed), because a level file is
/// padded to a page.
constexpr std::uint64_t kMaxLevelBytes =
    static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) - 4096;

std::uint64_t checked_product(std::uint64_t a, std::uint64_t b, std::int64_t side,
                              std::uint64_t edge_count) {
  if (b != 0 && a > kMaxLevelBytes / b)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out slots of {0} x {0} records on {1} edges: expected at most {2} "
                            "bytes, found more",
                            side, edge_count, kMaxLevelBytes));
  return a * b;
}

}  // namespace

LevelGeometry::LevelGeometry(const SlotShapes& shapes, BaseRelativeLevel level,
                             std::size_t record_bytes, std::uint64_t block_bytes)
    : all_whole_(shapes.half().empty() && shapes.absent().empty()),
      has_absent_(!shapes.absent().empty()),
      level_(level),
      record_bytes_(record_bytes),
      shapes_(shapes) {
  if (level.refinements < 1 || level.refinements > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out a level: expected 1 to {} refinements of the base mesh, found "
                            "{}",
                            kMaxLevel, level.refinements));
  const std::int64_t side = slot_side(level.refinements);
  const std::uint64_t edge_count = shapes.edge_count();
  if (record_bytes == 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out slots of {0} x {0} records: expected records of at least 1 "
                            "byte, found 0",
                            side));
  if (edge_count >= kNoId)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out slots of {0} x {0} records: expected fewer than {1} edges, "
                            "found {2}",
                            side, kNoId, edge_count));

  whole_bytes_ = checked_product(slot_records(level.refinements), record_bytes, side, edge_count);
  checked_product(whole_bytes_, edge_count, side, edge_count);
  half_saving_bytes_ =
      whole_bytes_ - slot_records(level.refinements, SlotShape::kHalf) * record_bytes;
  total_bytes_ = offset_of(edge_count);

  const std::uint64_t slot_count = shapes.slot_count();
  while (whole_bytes_ <= block_bytes >> (shift_ + 1) && std::uint64_t{1} << shift_ < slot_count)
    ++shift_;
  block_count_ = slot_count == 0 ? 0 : ((slot_count - 1) >> shift_) + 1;
  max_block_bytes_ = std::min(whole_bytes_ << shift_, total_bytes_);
}

Slot LevelGeometry::shaped_slot(EdgeId edge) const {
  const EdgeSet::Position half = shapes_.half().find(edge);
  const EdgeSet::Position absent =
      has_absent_ ? shapes_.absent().find(edge) : EdgeSet::Position{0, false};
  const std::uint64_t offset = (edge - absent.rank) * whole_bytes_ - half.rank * half_saving_bytes_;
  if (half.is_member) return {offset, whole_bytes_ - half_saving_bytes_, SlotShape::kHalf};
  if (absent.is_member) return {offset, 0, SlotShape::kAbsent};
  return {offset, whole_bytes_, SlotShape::kWhole};
}

EdgeId LevelGeometry::first_edge(std::uint64_t block) const {
  if (block >= block_count_) return static_cast<EdgeId>(edge_count());
  const std::uint64_t slots_before = block << shift_;
  if (shapes_.absent().empty()) return static_cast<EdgeId>(slots_before);
  // A binary search for the first edge with `slots_before` slots before it, not counting absent
  // ones.
  std::uint64_t first = 0, after = edge_count();
  while (first < after) {
    const std::uint64_t middle = first + (after - first) / 2;
    if (present_before(middle) < slots_before)
      first = middle + 1;
    else
      after = middle;
  }
  return static_cast<EdgeId>(first);
}

std::uint64_t LevelGeometry::block_at(std::uint64_t offset) const {
  // The last block that begins at or before the offset.
  std::uint64_t first = 0, after = block_count_;
  while (after - first > 1) {
    const std::uint64_t middle = first + (after - first) / 2;
    (block_offset(middle) <= offset ? first : after) = middle;
  }
  return first;
}

PLAIT_END_NAMESPACE
