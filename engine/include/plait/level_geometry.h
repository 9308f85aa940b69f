// plait/level_geometry.h: where slots and blocks lie in one level of one attribute.
//
//   slot offset of edge e = (e n^2 - border_rank(e) n(n-1)/2) record_bytes,   n = 2^(level-1)
//
// where border_rank counts the border edges before e, whose slots are triangles. A block is a run
// of 2^s slots. Nothing lies between slots nor between blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/base_relative_level.h"
#include "plait/topology.h"

namespace plait {

/// Immutable; safe from any number of threads.
class LevelGeometry {
 public:
  LevelGeometry() = default;
  /// `level` is at least 1. `border_edges` is ascending and must outlive this object. A block holds
  /// as many slots as fit into `block_bytes`, a power of two, at least one, and no more than the
  /// level has.
  LevelGeometry(std::uint64_t edge_count, std::span<const EdgeId> border_edges,
                BaseRelativeLevel level, std::size_t record_bytes, std::uint64_t block_bytes);

  BaseRelativeLevel level() const { return level_; }
  std::size_t record_bytes() const { return record_bytes_; }
  std::uint64_t edge_count() const { return edge_count_; }
  bool is_border(EdgeId edge) const;

  std::uint64_t slot_offset(EdgeId edge) const;  ///< bytes from the start of the level
  /// The same where the number of border edges before `edge` is known.
  std::uint64_t slot_offset(EdgeId edge, std::uint64_t border_rank) const {
    return edge * full_slot_bytes_ - border_rank * border_saving_bytes_;
  }
  std::uint64_t slot_bytes(EdgeId edge) const;

  std::uint64_t block_count() const { return block_count_; }
  int slots_per_block_log2() const { return shift_; }
  std::uint64_t block_of(EdgeId edge) const { return std::uint64_t{edge} >> shift_; }
  EdgeId first_edge(std::uint64_t block) const;           ///< first edge of the block
  EdgeId edge_after(std::uint64_t block) const;           ///< one past its last edge
  std::uint64_t block_offset(std::uint64_t block) const;  ///< block_count() gives the total
  std::uint64_t block_bytes(std::uint64_t block) const;
  std::uint64_t max_block_bytes() const { return max_block_bytes_; }
  std::uint64_t total_bytes() const { return total_bytes_; }
  /// Bytes of `count` blocks from `first` on.
  std::uint64_t range_bytes(std::uint64_t first, std::uint64_t count) const {
    return block_offset(first + count) - block_offset(first);
  }

 private:
  std::uint64_t offset_of(std::uint64_t edge) const;

  std::uint64_t edge_count_ = 0;
  std::span<const EdgeId> border_edges_;
  BaseRelativeLevel level_{1};
  int shift_ = 0;
  std::size_t record_bytes_ = 0;
  std::uint64_t full_slot_bytes_ = 0, border_saving_bytes_ = 0;
  std::uint64_t block_count_ = 0, max_block_bytes_ = 0, total_bytes_ = 0;
};

}  // namespace plait
