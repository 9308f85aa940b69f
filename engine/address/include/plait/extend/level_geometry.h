// plait/extend/level_geometry.h: the offsets and sizes of slots and blocks in one level of one
// attribute. No other code computes an offset.
//
//   offset of edge e = (whole(e) n^2 + half(e) n(n+1)/2) record_bytes,   n = 2^(level-1)
//
// where whole(e) and half(e) count the slots of these shapes that belong to edges before e. A block
// is a run of 2^s slots, not counting absent ones. There are no bytes between slots or between
// blocks.
//
// A level in shards has the same offsets. But each shard begins a block, and so has a last block of
// its own that may be short. Blocks are numbered through all shards. The geometry of one shard
// alone counts blocks and offsets from the shard's first edge.
// Pinned by tests/engine/address/level_geometry_test.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "plait/detail/edge_shards.h"
#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The place of an edge's records in a level, and their number.
struct Slot {
  std::uint64_t offset = 0;  ///< bytes from the start of the level
  std::uint64_t bytes = 0;
  SlotShape shape = SlotShape::kWhole;
};

/// Immutable and safe from any number of threads.
class LevelGeometry {
 public:
  LevelGeometry() = default;
  /// `level` is at least 1. The number of slots in a block is the largest power of two for which a
  /// block of whole slots fits into `block_bytes`, but at least one and not more than the level
  /// needs.
  /// Errors: kInvalidArgument for a level or a size that a file cannot have.
  LevelGeometry(const SlotShapes& shapes, BaseRelativeLevel level, std::size_t record_bytes,
                std::uint64_t block_bytes);

  /// The same level in these shards; with no shards, the same geometry.
  LevelGeometry in_shards(const EdgeShards& shards) const;
  /// One shard alone. Only its edges have slots. REQUIRES: in_shards(), of more than `shard`.
  LevelGeometry shard(std::uint32_t shard) const;
  /// The shards of the level; none for a level in one piece, and for one shard alone.
  const EdgeShards& shards() const { return shards_; }
  /// The first block of a shard; block_count() for the number of shards. REQUIRES: in_shards().
  std::uint64_t first_block(std::uint32_t shard) const { return (*first_blocks_)[shard]; }
  std::uint32_t shard_of_block(std::uint64_t block) const;

  BaseRelativeLevel level() const { return level_; }
  std::size_t record_bytes() const { return record_bytes_; }
  std::uint64_t edge_count() const { return shapes_.edge_count(); }

  /// The slot of an edge, in constant time.
  Slot slot(EdgeId edge) const {
    if (!plain_slots_) [[unlikely]]
      return shaped_slot(edge);
    return {edge * whole_bytes_ - origin_, whole_bytes_, SlotShape::kWhole};
  }

  /// Whether the slot of the edge is not absent.
  bool has_slot(EdgeId edge) const { return !shapes_.absent().contains(edge); }

  std::uint64_t block_count() const { return block_count_; }
  int slots_per_block_log2() const { return shift_; }
  /// The block whose range of edges contains this edge, in constant time. REQUIRES: block_count() >
  /// 0.
  std::uint64_t block_of(EdgeId edge) const {
    if (!plain_blocks_) [[unlikely]]
      return uneven_block_of(edge);
    return std::uint64_t{edge} >> shift_;
  }
  EdgeId first_edge(std::uint64_t block) const;  ///< first edge of the block
  /// The block that has the byte at `offset`. REQUIRES: offset < total_bytes().
  std::uint64_t block_at(std::uint64_t offset) const;
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
  /// total_bytes() of the same edges at another level. REQUIRES: no slot is absent.
  std::uint64_t total_bytes_at(BaseRelativeLevel level) const;
  /// Bytes of `count` blocks from `first` on.
  std::uint64_t range_bytes(std::uint64_t first, std::uint64_t count) const {
    return block_offset(first + count) - block_offset(first);
  }

 private:
  /// slot() for levels with half or absent slots. A function of its own, so that slot() stays
  /// short.
  Slot shaped_slot(EdgeId edge) const;
  std::uint64_t uneven_block_of(EdgeId edge) const;
  std::uint64_t blocks_of(EdgeId first, EdgeId after) const;
  std::uint64_t present_before(std::uint64_t edge) const {
    return edge - shapes_.absent().rank(edge);
  }
  std::uint64_t offset_of(std::uint64_t edge) const {
    return present_before(edge) * whole_bytes_ - shapes_.half().rank(edge) * half_saving_bytes_ -
           origin_;
  }

  // The members that every look-up of a slot reads come first. On a closed mesh, they are all that
  // a look-up reads, and they are in one cache line.
  std::uint64_t whole_bytes_ = 0, half_saving_bytes_ = 0;
  std::uint64_t origin_ = 0;  ///< bytes of the level before first_edge_
  int shift_ = 0;
  bool plain_slots_ = true;   ///< all slots are whole
  bool plain_blocks_ = true;  ///< no slot is absent, and all blocks but the last are full
  BaseRelativeLevel level_{1};
  std::size_t record_bytes_ = 0;
  std::uint64_t block_count_ = 0, max_block_bytes_ = 0, total_bytes_ = 0;
  SlotShapes shapes_;
  EdgeId first_edge_ = 0, edge_after_ = 0;  ///< the edges that have slots here
  EdgeShards shards_;
  std::shared_ptr<const std::vector<std::uint64_t>> first_blocks_;  ///< [shard], and then the end
};

PLAIT_END_NAMESPACE
