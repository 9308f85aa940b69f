#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "bench/contests.h"

namespace plait::bench {

std::string verdict_of(const Findings& findings) {
  struct Disk {
    std::map<std::string, int> wins;
    int undecided = 0, alone = 0;
  };
  std::map<std::string, Disk> disks;
  for (const Contest& contest : findings.contests) {
    Disk& disk = disks[findings.cells[contest.cells.front()].cell.disk];
    if (contest.decided)
      ++disk.wins[findings.cells[contest.cells.front()].name];
    else if (contest.cells.size() < 2)
      ++disk.alone;
    else
      ++disk.undecided;
  }
  std::vector<std::string> parts;
  for (const auto& [name, disk] : disks) {
    int decided = 0;
    std::vector<std::pair<int, std::string>> winners;
    for (const auto& [backend, wins] : disk.wins) {
      decided += wins;
      winners.emplace_back(-wins, backend);
    }
    std::sort(winners.begin(), winners.end());
    const std::string where = fmt::format("on {}", name.empty() ? "a disk without a name" : name);
    const int all = decided + disk.undecided;
    if (all == 0) {
      parts.push_back(where + " there is one way only, and nothing to compare it with");
    } else if (decided == 0) {
      parts.push_back(
          fmt::format("{} nothing is decided ({} comparison{})", where, all, all == 1 ? "" : "s"));
    } else {
      std::vector<std::string> counts;
      for (const auto& [wins, backend] : winners) {
        if (counts.size() == 3) break;
        counts.push_back(fmt::format("{} is the fastest in {} of {}", backend, -wins, all));
      }
      parts.push_back(fmt::format(
          "{} {}{}", where, fmt::join(counts, ", "),
          disk.undecided > 0 ? fmt::format(", {} undecided", disk.undecided) : std::string()));
    }
    if (parts.size() == 8) break;
  }
  std::string sentence = fmt::format("{}.", fmt::join(parts, "; "));
  sentence[0] = 'O';
  return sentence;
}

}  // namespace plait::bench
