#include "plait/detail/edge_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

EdgeSet::EdgeSet(std::span<const EdgeId> edges) {
  if (edges.empty()) return;
  const auto unordered = std::ranges::adjacent_find(edges, std::ranges::greater_equal());
  if (unordered != edges.end())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("make a set of edges: expected ascending edges, found {} before {}",
                            unordered[0], unordered[1]));
  size_ = edges.size();
  end_ = std::uint64_t{edges.back()} + 1;
  std::vector<EdgeGroup> groups((end_ + 63) / 64);
  for (const EdgeId edge : edges) groups[edge / 64].members |= std::uint64_t{1} << edge % 64;
  std::uint64_t before = 0;
  for (EdgeGroup& group : groups) {
    group.before = before;
    before += count_bits(group.members);
  }
  owned_ = std::make_shared<const std::vector<EdgeGroup>>(std::move(groups));
  groups_ = *owned_;
}

bool EdgeSet::intersects(const EdgeSet& other) const noexcept {
  const std::size_t common = std::min(groups_.size(), other.groups_.size());
  for (std::size_t group = 0; group < common; ++group)
    if ((groups_[group].members & other.groups_[group].members) != 0) return true;
  return false;
}

PLAIT_END_NAMESPACE
