// plait/edge_set.h: a set of edges that answers in constant time whether it has an edge, and how
// many of its edges come before one (the edge's rank).
//
// A bit for each edge, and beside each 64 bits the number of members before them: one word and one
// count answer a question. Source: G. Jacobson, "Space-efficient static trees and graphs", 1989,
// section 2, with one kind of blocks. Pinned by tests/engine/address/edge_set_test.cpp.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/topology.h"

namespace plait {

/// Immutable. Copies share their memory: 16 bytes for each 64 edges up to the largest member, and
/// nothing for the empty set. Safe from any number of threads.
class EdgeSet {
 public:
  EdgeSet() = default;
  /// Errors: kInvalidArgument unless `edges` ascend.
  explicit EdgeSet(std::span<const EdgeId> edges);

  bool empty() const noexcept { return size_ == 0; }
  std::uint64_t size() const noexcept { return size_; }
  /// One more than the largest member; 0 for the empty set.
  std::uint64_t end() const noexcept { return end_; }
  std::uint64_t memory_bytes() const noexcept { return parts_.size_bytes(); }

  bool contains(std::uint64_t edge) const noexcept {
    return edge / 64 < parts_.size() && (parts_[edge / 64].members >> edge % 64 & 1) != 0;
  }
  /// Members below `edge`, which may be any number.
  std::uint64_t rank(std::uint64_t edge) const noexcept {
    if (edge / 64 >= parts_.size()) return size_;
    const Part& part = parts_[edge / 64];
    const std::uint64_t below = part.members & ((std::uint64_t{1} << edge % 64) - 1);
    // Borders are rare: most often there is nothing to count, which saves a call where the
    // processor's own instruction may not be used.
    return below == 0 ? part.before
                      : part.before + static_cast<std::uint64_t>(std::popcount(below));
  }
  bool intersects(const EdgeSet& other) const noexcept;

 private:
  struct Part {
    std::uint64_t members = 0;  ///< bit i: edge 64 times the part's number, and i
    std::uint64_t before = 0;   ///< members of the parts before
  };
  std::shared_ptr<const std::vector<Part>> owned_;
  std::span<const Part> parts_;  ///< of owned_
  std::uint64_t size_ = 0, end_ = 0;
};

}  // namespace plait
