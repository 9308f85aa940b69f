// plait/detail/edge_shards.h: how the levels of a store are cut into shards. A shard is a range of
// consecutive edges, in all levels of all attributes. Each machine of many makes one
// (docs/many-machines.md).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/detail/edge_set.h"
#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The most shards of a store.
inline constexpr std::uint64_t kMostShards = std::uint64_t{1} << 20;

/// Immutable, cheap to copy, and safe from any number of threads.
class EdgeShards {
 public:
  /// No shards: the levels are in one piece.
  EdgeShards() = default;
  /// `starts` are the first edges of the shards, of a mesh with `edge_count` edges. Errors:
  /// kInvalidArgument unless they begin with 0, ascend, are below `edge_count` and at most
  /// kMostShards.
  EdgeShards(std::vector<EdgeId> starts, std::uint64_t edge_count);

  bool empty() const noexcept { return !starts_; }
  std::uint32_t size() const noexcept {
    return empty() ? 0 : static_cast<std::uint32_t>(starts_->size());
  }
  std::span<const EdgeId> starts() const noexcept {
    return empty() ? std::span<const EdgeId>() : std::span<const EdgeId>(*starts_);
  }
  EdgeId first_edge(std::uint32_t shard) const { return (*starts_)[shard]; }
  EdgeId edge_after(std::uint32_t shard) const {
    return shard + 1 < size() ? (*starts_)[shard + 1] : static_cast<EdgeId>(edge_count_);
  }
  /// The shard of an edge, in constant time. REQUIRES: !empty().
  std::uint32_t shard_of(EdgeId edge) const noexcept {
    const EdgeSet::Position found = set_.find(edge);
    return static_cast<std::uint32_t>(found.rank + (found.is_member ? 1 : 0) - 1);
  }

 private:
  std::shared_ptr<const std::vector<EdgeId>> starts_;
  EdgeSet set_;
  std::uint64_t edge_count_ = 0;
};

PLAIT_END_NAMESPACE
