// What a reader needs first: how much is decided, who wins where, and advice.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "backends/report_page.h"

namespace plait::bench {
namespace {

constexpr double kNever = 2;  // times as long

/// Those in which there is something to compare.
std::vector<Contest> contests_in(const Findings& findings) {
  std::vector<Contest> found = findings.contests;
  std::erase_if(found, [](const Contest& contest) { return contest.cells.size() < 2; });
  return found;
}

/// Who must not be used in a contest, and why.
std::vector<std::pair<std::string, std::string>> banned(const Findings& findings,
                                                        const Contest& contest) {
  std::vector<std::pair<std::string, std::string>> list;
  for (const std::size_t at : contest.cells)
    if (const CellFigures& figures = findings.cells[at]; figures.failed > 0)
      list.emplace_back(figures.name, survival_of(figures));
  for (const Rival& rival : contest.rivals)
    if (rival.answer == Answer::kSlower && rival.factor.low >= kNever)
      list.emplace_back(findings.cells[rival.cell].name,
                        fmt::format("{:.2g} times as long", rival.factor.value));
  return list;
}

/// The fastest cell and those that may be it, if they are of one backend.
std::vector<std::string> fastest_of(const Findings& findings, const Contest& contest) {
  std::vector<std::string> fastest;
  if (!contest.decided && !contest.backend_decided && contest.ranked != 1) return fastest;
  fastest.push_back(findings.cells[contest.cells.front()].name);
  for (const Rival& rival : contest.rivals)
    if (rival.answer == Answer::kUndecided) fastest.push_back(findings.cells[rival.cell].name);
  return fastest;
}

/// How many times as long as the fastest one a cell took; infinite if runs of it failed.
double factor_of(const Findings& findings, const Contest& contest, std::size_t cell) {
  if (findings.cells[cell].failed > 0) return std::numeric_limits<double>::infinity();
  const auto rival = std::ranges::find(contest.rivals, cell, &Rival::cell);
  return rival == contest.rivals.end() ? 1 : rival->factor.value;
}

}  // namespace

instrument::Table matrix_table(const Findings& findings) {
  using instrument::Tone;
  instrument::Table table = instrument::table_with(
      "disk|workload|size|fastest|others|never",
      {"Which backend for which work",
       "Compared in pairs by round, on the logarithm of seconds, with intervals "
       "that are corrected for how many comparisons there are. Never: twice the "
       "time of the fastest or more, or runs that died."});
  for (const Contest& contest : contests_in(findings)) {
    std::vector<std::string> others, never;
    for (const Rival& rival : contest.rivals)
      if (rival.answer == Answer::kEqual ||
          (rival.answer == Answer::kSlower && rival.factor.low < kNever))
        others.push_back(fmt::format("{} {}", findings.cells[rival.cell].name, answer_text(rival)));
    if (!contest.decided && !contest.why_not.empty()) others.push_back(contest.why_not);
    for (const auto& [name, why] : banned(findings, contest))
      never.push_back(fmt::format("never {} ({})", name, why));
    const std::vector<std::string> fastest = fastest_of(findings, contest);
    const MeasuredCell& first = findings.cells[contest.cells.front()].cell;
    table.rows.push_back(
        {{first.disk, first.workload, size_of(first),
          fastest.empty() ? "undecided" : fmt::format("{}", fmt::join(fastest, " or ")),
          fmt::format("{}", fmt::join(others, "; ")), fmt::format("{}", fmt::join(never, "; "))},
         findings.failed ? Tone::kFailed : Tone::kPlain});
  }
  return table;
}

std::vector<std::string> advice_of(const Findings& findings) {
  struct Disk {
    std::map<std::string, int> good;  ///< how often it is among the fastest
    std::map<std::string, std::vector<std::string>> never;
    int all = 0;
  };
  std::map<std::string, Disk> disks;
  for (const Contest& contest : contests_in(findings)) {
    const MeasuredCell& first = findings.cells[contest.cells.front()].cell;
    Disk& disk = disks[first.disk];
    ++disk.all;
    const std::vector<std::string> fastest = fastest_of(findings, contest);
    for (const std::string& name : fastest) ++disk.good[name];
    for (const Rival& rival : contest.rivals)
      if (!fastest.empty() && rival.answer == Answer::kEqual)
        ++disk.good[findings.cells[rival.cell].name];
    for (const auto& [name, why] : banned(findings, contest))
      disk.never[name].push_back(fmt::format("{} ({})", first.workload, why));
  }
  std::vector<std::string> lines;
  for (const auto& [name, disk] : disks) {
    const auto best =
        std::ranges::max_element(disk.good, {}, [](auto& each) { return each.second; });
    std::string& line = lines.emplace_back(
        fmt::format("On {}: {}", name.empty() ? "a disk without a name" : name,
                    disk.good.empty() ? "nothing is decided"
                                      : fmt::format("use {}, among the fastest in {} of {}",
                                                    best->first, best->second, disk.all)));
    for (const auto& [backend, reasons] : disk.never)
      line +=
          fmt::format("; never {} for {}{}", backend, reasons.front(),
                      reasons.size() > 1 ? fmt::format(" and {} more", reasons.size() - 1) : "");
    line += ".";
  }
  return lines;
}

/// `auto` compresses nothing by itself, so it is held against what stores with the same pipeline.
std::string text_about_auto(const Findings& findings) {
  constexpr double kNear = 1.1;
  int near = 0, all = 0;
  double farthest = 0;
  std::string where;
  for (const Contest& contest : contests_in(findings)) {
    const std::span ranked = std::span(contest.cells).first(contest.ranked);
    for (const std::size_t at : contest.cells) {
      const CellFigures& figures = findings.cells[at];
      const bool is_ranked = std::ranges::find(ranked, at) != ranked.end();
      if (!figures.is_auto || (figures.failed == 0 && (!is_ranked || contest.ranked < 2))) continue;
      ++all;
      double fastest = std::numeric_limits<double>::infinity();
      for (const std::size_t other : ranked)
        if (findings.cells[other].cell.pipeline == figures.cell.pipeline)
          fastest = std::min(fastest, factor_of(findings, contest, other));
      const double factor =
          factor_of(findings, contest, at) / (std::isfinite(fastest) ? fastest : 1);
      near += factor <= kNear;
      if (factor <= farthest) continue;
      farthest = factor;
      where = fmt::format("{} on {} ({}{})", figures.cell.workload, figures.cell.disk, figures.name,
                          figures.failed > 0 ? ", " + survival_of(figures) : "");
    }
  }
  if (all == 0) return {};
  return fmt::format(" auto is within {:.0f} % of the fastest that does not compress in {} of {}{}",
                     100 * (kNear - 1), near, all,
                     near == all ? "."
                     : std::isfinite(farthest)
                         ? fmt::format("; the farthest is {:.2f} times, for {}.", farthest, where)
                         : fmt::format("; it fails for {}.", where));
}

std::string verdict_of(const Findings& findings) {
  const auto all = contests_in(findings).size();
  if (all == 0) return "There is one way only, and nothing to compare it with.";
  const auto decided = std::ranges::count_if(findings.contests, &Contest::decided);
  const auto presets = std::ranges::count_if(findings.contests, &Contest::backend_decided);
  return fmt::format("{} of {} comparison{} decided{}.{}", decided, all, all == 1 ? " is" : "s are",
                     presets == 0 ? "" : fmt::format(", and {} more but for the pipeline", presets),
                     text_about_auto(findings));
}

}  // namespace plait::bench
