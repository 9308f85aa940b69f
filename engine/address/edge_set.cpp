#include "plait/edge_set.h"

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
  std::vector<Part> parts((end_ + 63) / 64);
  for (const EdgeId edge : edges) parts[edge / 64].members |= std::uint64_t{1} << edge % 64;
  std::uint64_t before = 0;
  for (Part& part : parts) {
    part.before = before;
    before += static_cast<std::uint64_t>(std::popcount(part.members));
  }
  owned_ = std::make_shared<const std::vector<Part>>(std::move(parts));
  parts_ = *owned_;
}

bool EdgeSet::intersects(const EdgeSet& other) const noexcept {
  const std::size_t common = std::min(parts_.size(), other.parts_.size());
  for (std::size_t part = 0; part < common; ++part)
    if ((parts_[part].members & other.parts_[part].members) != 0) return true;
  return false;
}

PLAIT_END_NAMESPACE
