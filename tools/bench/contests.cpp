#include "bench/contests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <tuple>

namespace plait::bench {
namespace {

using instrument::Estimate;

/// The label whose cells are ranked: cold ones if there are any; warm ones never.
std::string ranked_label(const std::vector<CellFigures>& cells,
                         const std::vector<std::size_t>& among) {
  std::string found = "warm";
  for (const std::size_t at : among) {
    if (!cells[at].seconds || cells[at].label == "warm") continue;
    if (found == "warm" || cells[at].label == "cold") found = cells[at].label;
  }
  return found;
}

/// The times that are compared: seconds in which the drift of the disk from round to round is
/// cancelled. In each round that all ranked cells have, they are divided by the geometric mean of
/// these cells' floors: the same divisor for all, so that no cell gains by a slow floor. Where
/// there are too few such rounds, the seconds themselves.
std::vector<Estimate> compared_times(const RunSet& set, const std::vector<CellFigures>& cells,
                                     std::span<const std::size_t> ranked) {
  struct Round {
    double logarithms = 0;
    std::vector<double> seconds;
  };
  std::map<std::uint64_t, Round> rounds;
  for (const std::size_t at : ranked) {
    std::set<std::uint64_t> seen;
    for (const std::size_t index : cells[at].runs) {
      const MeasuredRun& run = set.runs[index];
      if (run.floor_seconds.value_or(0) <= 0 || !seen.insert(run.round).second) continue;
      rounds[run.round].logarithms += std::log(*run.floor_seconds);
      rounds[run.round].seconds.push_back(run.seconds);
    }
  }
  std::erase_if(rounds,
                [&](const auto& round) { return round.second.seconds.size() < ranked.size(); });
  std::vector<Estimate> times;
  for (std::size_t place = 0; place < ranked.size(); ++place) {
    std::vector<double> values;
    values.reserve(rounds.size());
    for (const auto& [number, round] : rounds)
      values.push_back(round.seconds[place] /
                       std::exp(round.logarithms / static_cast<double>(ranked.size())));
    times.push_back(values.size() < kLeastRounds ? *cells[ranked[place]].seconds
                                                 : instrument::median_interval(values));
  }
  return times;
}

void rank(Contest& contest, const RunSet& set, const std::vector<CellFigures>& cells) {
  const std::string label = ranked_label(cells, contest.cells);
  const auto can_rank = [&](std::size_t at) {
    return label != "warm" && cells[at].seconds && cells[at].label == label;
  };
  const auto first_unranked =
      std::stable_partition(contest.cells.begin(), contest.cells.end(), can_rank);
  contest.ranked = static_cast<std::size_t>(first_unranked - contest.cells.begin());
  const std::span<const std::size_t> ranked(contest.cells.data(), contest.ranked);
  const std::vector<Estimate> times = compared_times(set, cells, ranked);
  std::vector<std::pair<Estimate, std::size_t>> order;
  for (std::size_t at = 0; at < contest.ranked; ++at) order.emplace_back(times[at], ranked[at]);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first.value < b.first.value; });
  for (std::size_t at = 0; at < contest.ranked; ++at) contest.cells[at] = order[at].second;
  if (label == "warm") {
    contest.why_not = "no run was cold";
    return;
  }
  if (contest.ranked < 2) {
    contest.why_not = "there is nothing to compare it with";
    return;
  }
  const Estimate& first = order[0].first;
  contest.lead = order[1].first.value / first.value;
  for (const auto& [time, at] : order) {
    if (cells[at].seconds->count < kLeastRounds)
      contest.why_not = fmt::format("fewer than {} rounds", kLeastRounds);
    else if (at != order[0].second && time.overlaps(first) && contest.why_not.empty())
      contest.why_not = fmt::format("the intervals of {} and {} overlap",
                                    cells[order[0].second].name, cells[at].name);
  }
  contest.decided = contest.why_not.empty();
}

}  // namespace

std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells) {
  using Key = std::tuple<std::string, std::string, std::string, double, double, double, double,
                         double, bool>;
  std::map<Key, Contest> contests;
  for (std::size_t at = 0; at < cells.size(); ++at) {
    const MeasuredCell& cell = cells[at].cell;
    contests[{cell.disk, cell.mesh, cell.workload, cell.vertices.value_or(0),
              cell.levels.value_or(0), cell.memory.value_or(0), cell.ratio.value_or(0),
              cell.rate.value_or(0), cell.durable}]
        .cells.push_back(at);
  }
  std::vector<Contest> result;
  for (auto& [key, contest] : contests) {
    rank(contest, set, cells);
    result.push_back(std::move(contest));
  }
  return result;
}

}  // namespace plait::bench
