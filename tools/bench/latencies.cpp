#include "bench/latencies.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plait::bench {
namespace {

/// The smallest latency that at least `fraction` of the requests did not exceed.
double quantile(const std::vector<double>& sorted, double fraction) {
  const auto rank =
      static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(sorted.size())));
  return sorted[std::min(std::max<std::size_t>(rank, 1), sorted.size()) - 1];
}

}  // namespace

nlohmann::ordered_json latencies_to_json(std::vector<double> seconds) {
  if (seconds.empty()) return nullptr;
  std::ranges::sort(seconds);
  std::vector<double> edges = {0};
  std::vector<std::uint64_t> counts;
  auto at = seconds.begin();
  for (double edge = 1e-6; at != seconds.end(); edge *= 2) {
    const auto end = std::upper_bound(at, seconds.end(), edge);
    edges.push_back(edge);
    counts.push_back(static_cast<std::uint64_t>(end - at));
    at = end;
  }
  return {{"count", seconds.size()},
          {"p50", quantile(seconds, 0.5)},
          {"p90", quantile(seconds, 0.9)},
          {"p99", quantile(seconds, 0.99)},
          {"p999", quantile(seconds, 0.999)},
          {"max", seconds.back()},
          {"histogram", {{"edges", edges}, {"counts", counts}}}};
}

}  // namespace plait::bench
