// plait/detail/edge_set.h: a set of edges. In constant time it tells whether an edge is a member,
// and how many members come before an edge (the rank of the edge).
//
// The set has one bit for each edge, and for each 64 bits the number of members before them. So a
// query reads one word of bits and one number. Source: G. Jacobson, "Space-efficient static trees
// and graphs", 1989, section 2, with one level of blocks instead of two. Pinned by
// tests/engine/address/edge_set_test.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// Immutable and safe from any number of threads. Copies share their memory. A set takes 16 bytes
/// for each 64 edges up to the largest member; the empty set takes none.
class EdgeSet {
 public:
  EdgeSet() = default;
  /// Errors: kInvalidArgument unless `edges` ascend.
  explicit EdgeSet(std::span<const EdgeId> edges);

  bool empty() const noexcept { return size_ == 0; }
  std::uint64_t size() const noexcept { return size_; }
  /// One more than the largest member; 0 for the empty set.
  std::uint64_t end() const noexcept { return end_; }
  std::uint64_t memory_bytes() const noexcept { return groups_.size_bytes(); }

  bool contains(std::uint64_t edge) const noexcept {
    return edge / 64 < groups_.size() && (groups_[edge / 64].members >> edge % 64 & 1) != 0;
  }
  /// The number of members below `edge`. `edge` may be any number.
  std::uint64_t rank(std::uint64_t edge) const noexcept { return find(edge).rank; }

  /// What find() returns.
  struct Position {
    std::uint64_t rank = 0;
    bool is_member = false;
  };
  /// The answers of rank() and contains(), for the price of one.
  Position find(std::uint64_t edge) const noexcept {
    if (edge / 64 >= groups_.size()) return {size_, false};
    const EdgeGroup& group = groups_[edge / 64];
    const std::uint64_t bit = std::uint64_t{1} << edge % 64;
    return {group.before + count_bits(group.members & (bit - 1)), (group.members & bit) != 0};
  }
  bool intersects(const EdgeSet& other) const noexcept;

 private:
  /// As std::popcount, which is a function call where the build does not allow the processor's
  /// instruction.
  static std::uint64_t count_bits(std::uint64_t bits) noexcept {
    bits -= bits >> 1 & 0x5555'5555'5555'5555;
    bits = (bits & 0x3333'3333'3333'3333) + (bits >> 2 & 0x3333'3333'3333'3333);
    return ((bits + (bits >> 4)) & 0x0f0f'0f0f'0f0f'0f0f) * 0x0101'0101'0101'0101 >> 56;
  }
  struct EdgeGroup {
    std::uint64_t members = 0;  ///< bit i is edge 64 p + i, where p is the group's number
    std::uint64_t before = 0;   ///< members of the parts before
  };
  std::shared_ptr<const std::vector<EdgeGroup>> owned_;
  std::span<const EdgeGroup> groups_;  ///< of owned_
  std::uint64_t size_ = 0, end_ = 0;
};

PLAIT_END_NAMESPACE
