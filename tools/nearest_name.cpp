#include "nearest_name.h"

#include <algorithm>

namespace plait {
namespace {

/// Optimal string alignment distance: P. Damerau, "A technique for computer detection and
/// correction of spelling errors" (1964).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1,
                             cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  return cost[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  constexpr std::size_t kMostEdits = 2;
  constexpr std::size_t kLongestName = 32;  // a longer name is no typing error
  if (name.size() > kLongestName) return {};
  std::size_t fewest = std::min(kMostEdits + 1, name.size());
  std::string nearest;
  for (const std::string& known : names)
    if (const std::size_t edits = distance(name, known); edits < fewest) {
      fewest = edits;
      nearest = known;
    }
  return nearest;
}

}  // namespace plait
