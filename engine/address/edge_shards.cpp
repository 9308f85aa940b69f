#include "plait/detail/edge_shards.h"

#include <fmt/format.h>

#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

EdgeShards::EdgeShards(std::vector<EdgeId> starts, std::uint64_t edge_count)
    : set_(starts), edge_count_(edge_count) {
  if (starts.empty() || starts.size() > kMostShards || starts.front() != 0 ||
      starts.back() >= edge_count)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("cut {} edges into shards: expected 1 to {} shards from edge 0 on, "
                    "found {}, from edge {} to edge {}",
                    edge_count, kMostShards, starts.size(), starts.empty() ? 0 : starts.front(),
                    starts.empty() ? 0 : starts.back()));
  starts_ = std::make_shared<const std::vector<EdgeId>>(std::move(starts));
}

PLAIT_END_NAMESPACE
