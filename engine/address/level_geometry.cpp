#include "plait/level_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "plait/edge_index.h"
#include "plait/error.h"

namespace plait {
namespace {

/// File offsets are signed, and a level file is padded to a page.
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

LevelGeometry::LevelGeometry(std::uint64_t edge_count, std::span<const EdgeId> border_edges,
                             BaseRelativeLevel level, std::size_t record_bytes,
                             std::uint64_t block_bytes)
    : edge_count_(edge_count),
      border_edges_(border_edges),
      level_(level),
      record_bytes_(record_bytes) {
  if (level.refinements < 1 || level.refinements > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out a level: expected 1 to {} refinements of the base mesh, found "
                            "{}",
                            kMaxLevel, level.refinements));
  const std::int64_t side = slot_side(level.refinements);
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
  if (border_edges.size() > edge_count ||
      (!border_edges.empty() && border_edges.back() >= edge_count))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("lay out slots of {0} x {0} records: expected border edges below {1}, "
                            "found {2} ending with {3}",
                            side, edge_count, border_edges.size(), border_edges.back()));

  full_slot_bytes_ =
      checked_product(slot_records(level.refinements), record_bytes, side, edge_count);
  checked_product(full_slot_bytes_, edge_count, side, edge_count);
  border_saving_bytes_ = full_slot_bytes_ - slot_records(level.refinements, true) * record_bytes;
  total_bytes_ = offset_of(edge_count);

  while (full_slot_bytes_ <= block_bytes >> (shift_ + 1) && std::uint64_t{1} << shift_ < edge_count)
    ++shift_;
  block_count_ = edge_count == 0 ? 0 : ((edge_count - 1) >> shift_) + 1;
  max_block_bytes_ = std::min(full_slot_bytes_ << shift_, total_bytes_);
}

bool LevelGeometry::is_border(EdgeId edge) const {
  return !border_edges_.empty() &&
         std::binary_search(border_edges_.begin(), border_edges_.end(), edge);
}

std::uint64_t LevelGeometry::offset_of(std::uint64_t edge) const {
  const std::uint64_t closed = edge * full_slot_bytes_;
  if (border_edges_.empty()) return closed;
  const auto rank = static_cast<std::uint64_t>(
      std::lower_bound(border_edges_.begin(), border_edges_.end(), edge) - border_edges_.begin());
  return closed - rank * border_saving_bytes_;
}

std::uint64_t LevelGeometry::slot_offset(EdgeId edge) const { return offset_of(edge); }

std::uint64_t LevelGeometry::slot_bytes(EdgeId edge) const {
  return is_border(edge) ? full_slot_bytes_ - border_saving_bytes_ : full_slot_bytes_;
}

EdgeId LevelGeometry::first_edge(std::uint64_t block) const {
  return static_cast<EdgeId>(std::min(block << shift_, edge_count_));
}

EdgeId LevelGeometry::edge_after(std::uint64_t block) const { return first_edge(block + 1); }

std::uint64_t LevelGeometry::block_offset(std::uint64_t block) const {
  return offset_of(first_edge(block));
}

std::uint64_t LevelGeometry::block_bytes(std::uint64_t block) const {
  return range_bytes(block, 1);
}

}  // namespace plait
