// plait/level_geometry.h: where slots and blocks lie in one level of one attribute. Nobody else
// computes an offset, nor what one depends on.
//
//   offset of edge e = (whole(e) n^2 + half(e) n(n+1)/2) record_bytes,   n = 2^(level-1)
//
// where whole(e) and half(e) count the slots of these shapes that belong to edges before e. A block
// is a run of 2^s slots, absent ones not counted. Nothing lies between slots nor between blocks.
// Pinned by tests/engine/address/level_geometry_test.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "plait/base_relative_level.h"
#include "plait/slot_shapes.h"
#include "plait/topology.h"

namespace plait {

/// Where an edge's records lie in a level, and which of them there are.
struct Slot {
  std::uint64_t offset = 0;  ///< bytes from the start of the level
  std::uint64_t bytes = 0;
  SlotShape shape = SlotShape::kWhole;
};

/// Immutable; safe from any number of threads.
class LevelGeometry {
 public:
  LevelGeometry() = default;
  /// `level` is at least 1. A block holds as many slots as fit into `block_bytes` if all are whole,
  /// a power of two, at least one, and no more than the level has.
  /// Errors: kInvalidArgument for a level or a size that a file cannot have.
  LevelGeometry(const SlotShapes& shapes, BaseRelativeLevel level, std::size_t record_bytes,
                std::uint64_t block_bytes);

  BaseRelativeLevel level() const { return level_; }
  std::size_t record_bytes() const { return record_bytes_; }
  std::uint64_t edge_count() const { return shapes_.edge_count(); }

  /// In constant time.
  Slot slot(EdgeId edge) const {
    if (!all_whole_) [[unlikely]]
      return shaped_slot(edge);
    return {edge * whole_bytes_, whole_bytes_, SlotShape::kWhole};
  }

  std::uint64_t block_count() const { return block_count_; }
  int slots_per_block_log2() const { return shift_; }
  /// The block whose range of edges has this edge, in constant time. REQUIRES: there is a block.
  std::uint64_t block_of(EdgeId edge) const {
    if (has_absent_) [[unlikely]]
      return std::min(present_before(edge) >> shift_, block_count_ - 1);
    return std::uint64_t{edge} >> shift_;
  }
  EdgeId first_edge(std::uint64_t block) const;  ///< first edge of the block
  EdgeId edge_after(std::uint64_t block) const { return first_edge(block + 1); }
  std::uint64_t block_offset(std::uint64_t block) const {  ///< block_count() gives the total
    return offset_of(first_edge(block));
  }
  std::uint64_t block_bytes(std::uint64_t block) const { return range_bytes(block, 1); }
  /// Slots of the block that are not absent.
  std::uint64_t slot_count(std::uint64_t block) const {
    return present_before(edge_after(block)) - present_before(first_edge(block));
  }
  std::uint64_t max_block_bytes() const { return max_block_bytes_; }
  std::uint64_t total_bytes() const { return total_bytes_; }
  /// Bytes of `count` blocks from `first` on.
  std::uint64_t range_bytes(std::uint64_t first, std::uint64_t count) const {
    return block_offset(first + count) - block_offset(first);
  }

 private:
  /// Out of the way of those who ask for slots that are all whole.
  Slot shaped_slot(EdgeId edge) const;
  std::uint64_t present_before(std::uint64_t edge) const {
    return edge - shapes_.absent().rank(edge);
  }
  std::uint64_t offset_of(std::uint64_t edge) const {
    return present_before(edge) * whole_bytes_ - shapes_.half().rank(edge) * half_saving_bytes_;
  }

  // First what every look-up of a slot reads: on a closed mesh all of it is in one cache line.
  std::uint64_t whole_bytes_ = 0, half_saving_bytes_ = 0;
  int shift_ = 0;
  bool all_whole_ = true, has_absent_ = false;
  BaseRelativeLevel level_{1};
  std::size_t record_bytes_ = 0;
  std::uint64_t block_count_ = 0, max_block_bytes_ = 0, total_bytes_ = 0;
  SlotShapes shapes_;
};

}  // namespace plait
