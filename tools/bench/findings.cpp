#include "bench/findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <unordered_map>

#include "plait/byte_text.h"

namespace plait::bench {
namespace {

using instrument::Estimate;

/// Our own floor and fio's may differ by this share.
constexpr double kFloorsAgree = 0.10;
constexpr double kFasterSecondCold = 1.25;
constexpr double kOtherPrograms = 0.05;
constexpr double kNarrow = 0.05;

std::string bytes_text(double bytes) {
  return bytes < 1e18 ? size_text(static_cast<std::uint64_t>(bytes)) : fmt::format("{:.3g}", bytes);
}

/// Which options differ between the cells of a set: only those are worth a place in a name.
struct Varying {
  bool block = false, threads = false, budget = false;
};

Varying varying_of(const std::vector<CellFigures>& cells) {
  Varying varying;
  for (const CellFigures& figures : cells) {
    const MeasuredCell& first = cells.front().cell;
    varying.block |= figures.cell.block_bytes != first.block_bytes;
    varying.threads |= figures.cell.threads != first.threads;
    varying.budget |= figures.cell.budget != first.budget;
  }
  return varying;
}

std::string name_of(const MeasuredCell& cell, const Varying& varying) {
  std::string name = cell.backend;
  if (!cell.pipeline.empty() && cell.pipeline != "none") name += ", " + cell.pipeline;
  if (varying.block && cell.block_bytes)
    name += fmt::format(", blocks of {}", bytes_text(*cell.block_bytes));
  if (varying.threads && cell.threads) name += fmt::format(", {} threads", *cell.threads);
  if (varying.budget && cell.budget) name += fmt::format(", budget {}", bytes_text(*cell.budget));
  return name;
}

std::vector<double> values_of(const RunSet& set, const std::vector<std::size_t>& runs,
                              std::optional<double> MeasuredRun::*figure) {
  std::vector<double> values;
  for (const std::size_t at : runs)
    if (set.runs[at].*figure) values.push_back(*(set.runs[at].*figure));
  return values;
}

std::vector<CellFigures> cells_of(const RunSet& set) {
  std::vector<CellFigures> cells;
  std::unordered_map<std::string, std::size_t> by_key;
  for (std::size_t at = 0; at < set.runs.size(); ++at) {
    const MeasuredRun& run = set.runs[at];
    const auto [place, is_new] = by_key.try_emplace(run.key, cells.size());
    if (is_new) {
      cells.emplace_back();
      cells.back().cell = run.cell;
    }
    CellFigures& figures = cells[place->second];
    if (!run.ok) {
      ++figures.failed;
      continue;
    }
    figures.runs.push_back(at);
    if (figures.label.empty() || run.label == "warm") figures.label = run.label;
  }
  const Varying varying = varying_of(cells);
  for (CellFigures& figures : cells) {
    figures.name = name_of(figures.cell, varying);
    if (figures.runs.empty()) continue;
    std::vector<std::size_t> ordered = figures.runs;
    std::sort(ordered.begin(), ordered.end(), [&](std::size_t a, std::size_t b) {
      return set.runs[a].seconds < set.runs[b].seconds;
    });
    figures.middle = ordered[(ordered.size() - 1) / 2];
    std::vector<double> seconds;
    for (const std::size_t at : figures.runs) seconds.push_back(set.runs[at].seconds);
    figures.seconds = instrument::median_interval(seconds);
    const std::vector<double> ratios = values_of(set, figures.runs, &MeasuredRun::ratio);
    if (!ratios.empty()) figures.ratio = instrument::median_interval(ratios);
  }
  return cells;
}

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

std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells) {
  using Key = std::tuple<std::string, std::string, std::string, double, double, double, double,
                         double, bool>;
  std::map<Key, Contest> contests;
  for (std::size_t at = 0; at < cells.size(); ++at) {
    const MeasuredCell& cell = cells[at].cell;
    contests[{cell.disk, cell.directory, cell.workload, cell.vertices.value_or(0),
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

/// Collects doubts of runs: one line for each kind, with how many runs have it.
class Doubts {
 public:
  void add(const std::string& what) {
    if (counts_.size() < 100 || counts_.count(what) > 0) ++counts_[what];
  }
  void append_to(std::vector<std::string>& lines, std::size_t runs) const {
    for (const auto& [what, count] : counts_)
      lines.push_back(fmt::format("{} ({} of {} runs)", what, count, runs));
  }

 private:
  std::map<std::string, std::uint64_t> counts_;
};

void add_doubts_of_run(const MeasuredRun& run, Doubts& doubts) {
  if (!run.ok) {
    doubts.add(fmt::format("failed: {}", run.failure.empty()
                                             ? "for a reason that the record does not say"
                                             : run.failure));
    return;
  }
  if (run.limit_bytes.value_or(0) > 0 && !run.limit_held.value_or(false))
    doubts.add("the memory limit was not held, so the page cache may have helped");
  if (run.limit_bytes && *run.limit_bytes == 0)
    doubts.add("there was no memory limit, so the page cache may have helped");
  if (run.label == "warm")
    doubts.add("warm: the page cache held the data, so this is no figure of a disk");
  if (run.second_cold && *run.second_cold > kFasterSecondCold)
    doubts.add("a second cold read was faster: there is a cache below this machine");
  if (run.floor_seconds && run.fio_seconds &&
      std::abs(*run.floor_seconds - *run.fio_seconds) >
          kFloorsAgree * std::min(*run.floor_seconds, *run.fio_seconds))
    doubts.add("our floor and fio's differ by more than 10 %");
  const double others = run.others_read.value_or(0) + run.others_written.value_or(0);
  const double own = run.device_read.value_or(0) + run.device_written.value_or(0);
  if (own > 0 && others > kOtherPrograms * own)
    doubts.add("other programs used the device during the run");
  if (run.checksums && !*run.checksums) doubts.add("checksums were not verified");
  for (const std::string& doubt : run.doubts)
    if (run.label != "warm" || !doubt.starts_with("warm")) doubts.add(doubt);
}

void add_doubts_of_cells(const std::vector<CellFigures>& cells, std::vector<std::string>& lines) {
  std::size_t few = 0;
  std::size_t wide = 0;
  std::size_t no_floor = 0;
  for (const CellFigures& figures : cells) {
    if (!figures.seconds) continue;
    few += figures.seconds->count < kLeastRounds;
    no_floor += !figures.ratio.has_value();
    const Estimate& judged = figures.ratio ? *figures.ratio : *figures.seconds;
    wide += judged.count >= kLeastRounds && judged.relative_half_width() > kNarrow;
  }
  const auto add = [&](std::size_t count, const std::string& what) {
    if (count > 0) lines.push_back(fmt::format("{} of {} cells {}", count, cells.size(), what));
  };
  add(few, fmt::format("have fewer than {} rounds, which decides nothing", kLeastRounds));
  add(wide, "have an interval wider than 5 % on either side: more rounds narrow it");
  add(no_floor, "have no floor beside them, or one that was warm where the run was cold");
}

/// Runs of several machines or versions in one report may be meant, but have to be seen.
void add_doubts_of_environment(const RunSet& set, std::vector<std::string>& lines) {
  for (const auto& [name, what] :
       {std::pair("commit", "versions of plait"), std::pair("kernel", "kernels"),
        std::pair("processor", "processors")}) {
    std::set<std::string> values;
    for (const MeasuredRun& run : set.runs) {
      const auto found = run.environment.find(name);
      if (found != run.environment.end() && values.size() < 100) values.insert(found->second);
    }
    if (values.size() > 1)
      lines.push_back(fmt::format("the runs come from {} {}: {}", values.size(), what,
                                  fmt::join(values, ", ")));
  }
}

}  // namespace

std::string size_of(const MeasuredCell& cell) {
  if (cell.ratio) return fmt::format("{:.2g} × memory", *cell.ratio);
  if (cell.vertices) return fmt::format("{:.3g} million vertices", *cell.vertices / 1e6);
  return "";
}

std::string work_of(const MeasuredCell& cell) {
  std::string work = cell.workload;
  if (cell.rate) work += fmt::format(" at {:g}/s", *cell.rate);
  return work;
}

std::vector<std::string> digest_failures(const std::vector<MeasuredRun>& runs) {
  std::map<std::string, const MeasuredRun*> first_with;
  std::vector<std::string> failures;
  for (const MeasuredRun& run : runs) {
    if (run.digest_of.empty() || run.digest.empty()) continue;
    const auto [place, is_new] = first_with.try_emplace(run.digest_of, &run);
    const MeasuredRun& first = *place->second;
    if (first.digest == run.digest || failures.size() == 10) continue;
    failures.push_back(fmt::format("{}:{} ({}, {}) has digest {} of {}, but {}:{} ({}, {}) has {}",
                                   run.file, run.line, run.cell.workload, run.cell.backend,
                                   run.digest, run.digest_of, first.file, first.line,
                                   first.cell.workload, first.cell.backend, first.digest));
  }
  return failures;
}

Findings find(const RunSet& set) {
  Findings findings;
  findings.cells = cells_of(set);
  findings.contests = contests_of(set, findings.cells);
  findings.verdict = verdict_of(findings);
  findings.doubts = digest_failures(set.runs);
  findings.failed = !findings.doubts.empty();
  if (findings.failed)
    findings.verdict =
        "FAILED: runs that did the same work left different data, so no figure here counts.";
  Doubts doubts;
  for (const MeasuredRun& run : set.runs) add_doubts_of_run(run, doubts);
  doubts.append_to(findings.doubts, set.runs.size());
  add_doubts_of_cells(findings.cells, findings.doubts);
  add_doubts_of_environment(set, findings.doubts);
  if (set.skipped > 0) {
    findings.doubts.push_back(fmt::format("{} lines are no records and were skipped", set.skipped));
    findings.doubts.insert(findings.doubts.end(), set.skipped_lines.begin(),
                           set.skipped_lines.end());
  }
  findings.doubtful = !findings.doubts.empty();
  return findings;
}

}  // namespace plait::bench
