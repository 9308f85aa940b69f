#include "plait/extend/level_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

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
    : plain_slots_(shapes.half().empty() && shapes.absent().empty()),
      plain_blocks_(shapes.absent().empty()),
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
  edge_after_ = static_cast<EdgeId>(edge_count);
  total_bytes_ = offset_of(edge_count);

  const std::uint64_t slot_count = shapes.slot_count();
  while (whole_bytes_ <= block_bytes >> (shift_ + 1) && std::uint64_t{1} << shift_ < slot_count)
    ++shift_;
  block_count_ = blocks_of(0, edge_after_);
  max_block_bytes_ = std::min(whole_bytes_ << shift_, total_bytes_);
}

std::uint64_t LevelGeometry::blocks_of(EdgeId first, EdgeId after) const {
  const std::uint64_t slots = present_before(after) - present_before(first);
  return slots == 0 ? 0 : ((slots - 1) >> shift_) + 1;
}

LevelGeometry LevelGeometry::in_shards(const EdgeShards& shards) const {
  LevelGeometry result = *this;
  if (shards.empty()) return result;
  std::vector<std::uint64_t> first_blocks = {0};
  for (std::uint32_t shard = 0; shard < shards.size(); ++shard)
    first_blocks.push_back(first_blocks.back() +
                           blocks_of(shards.first_edge(shard), shards.edge_after(shard)));
  result.plain_blocks_ = false;
  result.shards_ = shards;
  result.block_count_ = first_blocks.back();
  result.first_blocks_ =
      std::make_shared<const std::vector<std::uint64_t>>(std::move(first_blocks));
  return result;
}

LevelGeometry LevelGeometry::shard(std::uint32_t shard) const {
  LevelGeometry result = *this;
  result.plain_blocks_ = false;
  result.first_edge_ = shards_.first_edge(shard);
  result.edge_after_ = shards_.edge_after(shard);
  result.block_count_ = blocks_of(result.first_edge_, result.edge_after_);
  result.origin_ = offset_of(result.first_edge_);
  result.total_bytes_ = result.offset_of(result.edge_after_);
  result.max_block_bytes_ = std::min(whole_bytes_ << shift_, result.total_bytes_);
  result.shards_ = {};
  result.first_blocks_.reset();
  return result;
}

std::uint64_t LevelGeometry::total_bytes_at(BaseRelativeLevel level) const {
  const std::uint64_t slots = present_before(edge_after_) - present_before(first_edge_),
                      half = shapes_.half().rank(edge_after_) - shapes_.half().rank(first_edge_);
  return ((slots - half) * slot_records(level.refinements) +
          half * slot_records(level.refinements, SlotShape::kHalf)) *
         record_bytes_;
}

std::uint32_t LevelGeometry::shard_of_block(std::uint64_t block) const {
  const auto after = std::ranges::upper_bound(*first_blocks_, block);
  return static_cast<std::uint32_t>(after - first_blocks_->begin()) - 1;
}

Slot LevelGeometry::shaped_slot(EdgeId edge) const {
  const EdgeSet::Position half = shapes_.half().find(edge);
  const EdgeSet::Position absent = shapes_.absent().find(edge);
  const std::uint64_t offset =
      (edge - absent.rank) * whole_bytes_ - half.rank * half_saving_bytes_ - origin_;
  // Without branches: where faces have depths of their own, no processor foresees the shape.
  const std::uint64_t is_half = half.is_member, is_absent = absent.is_member;
  static_assert(static_cast<int>(SlotShape::kWhole) == 0 &&
                static_cast<int>(SlotShape::kHalf) == 1 &&
                static_cast<int>(SlotShape::kAbsent) == 2);
  return {offset, whole_bytes_ * (1 - is_absent) - half_saving_bytes_ * is_half,
          static_cast<SlotShape>(is_half + 2 * is_absent)};
}

std::uint64_t LevelGeometry::uneven_block_of(EdgeId edge) const {
  // One shard alone, as the store of a part has it.
  if (shards_.empty() && shapes_.absent().empty())
    return std::min((std::uint64_t{edge} - first_edge_) >> shift_, block_count_ - 1);
  std::uint64_t first_block = 0, end = block_count_;
  EdgeId first = first_edge_;
  if (!shards_.empty()) {
    const std::uint32_t shard = shards_.shard_of(edge);
    first_block = this->first_block(shard);
    end = this->first_block(shard + 1);
    first = shards_.first_edge(shard);
  }
  const std::uint64_t block =
      first_block + ((present_before(edge) - present_before(first)) >> shift_);
  // An absent slot after the last one belongs to the last block. A shard whose slots are all absent
  // has no block: its edges belong to the first block after it, or to the last one of the level.
  return std::min({block, std::max(end, first_block + 1) - 1, block_count_ - 1});
}

EdgeId LevelGeometry::first_edge(std::uint64_t block) const {
  if (block >= block_count_) return edge_after_;
  EdgeId first = first_edge_;
  std::uint64_t first_block = 0;
  if (!shards_.empty()) {
    const std::uint32_t shard = shard_of_block(block);
    first = shards_.first_edge(shard);
    first_block = this->first_block(shard);
    // Shards without a block, whose edges uneven_block_of() gives to this one, begin there too.
    if (block == first_block)
      return shards_.first_edge(static_cast<std::uint32_t>(
          std::ranges::lower_bound(*first_blocks_, block) - first_blocks_->begin()));
  }
  const std::uint64_t slots_before = present_before(first) + ((block - first_block) << shift_);
  if (shapes_.absent().empty()) return static_cast<EdgeId>(slots_before);
  // A binary search for the first edge with `slots_before` slots before it, not counting absent
  // ones.
  std::uint64_t low = first, high = edge_after_;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (present_before(middle) < slots_before)
      low = middle + 1;
    else
      high = middle;
  }
  return static_cast<EdgeId>(low);
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
