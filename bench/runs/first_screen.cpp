// What a reader needs first: how much is known, what to take for which work, and advice.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

#include "runs/report_page.h"

namespace plait::bench {
namespace {

/// Those in which there is something to compare.
std::vector<Contest> contests_in(const Findings& findings) {
  std::vector<Contest> found = findings.contests;
  std::erase_if(found, [](const Contest& contest) { return contest.cells.size() < 2; });
  return found;
}

/// "uring (auto)".
std::string name_of(const CellFigures& figures) {
  return figures.name + (figures.is_auto ? " (auto)" : "");
}

/// Why a cell must not be taken: "mmap, 6.1 times", or "pread, 1 of 4 survived".
std::string never_text(const Findings& findings, const Contest& contest, std::size_t cell) {
  const CellFigures& figures = findings.cells[cell];
  if (figures.failed > 0) return name_of(figures) + ", " + survival_of(figures);
  const auto rival = std::ranges::find(contest.rivals, cell, &Rival::cell);
  return fmt::format("{}, {:.2g} times", name_of(figures), rival->factor.value);
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
  const std::vector<Contest> contests = contests_in(findings);
  const auto first_of = [&](const Contest& contest) -> const MeasuredCell& {
    return findings.cells[contest.cells.front()].cell;
  };
  const auto varies = [&](auto text_of) {
    return std::ranges::any_of(contests, [&](const Contest& contest) {
      return text_of(first_of(contest)) != text_of(first_of(contests.front()));
    });
  };
  // What is equal in all rows stands in the advice.
  const bool sizes = varies(size_of);
  instrument::Table table = instrument::table_with(
      sizes ? "disk|workload|size|take|others|never" : "disk|workload|take|others|never",
      {"What to take for which work",
       "Compared in pairs by round, on the logarithm of seconds, with intervals that are "
       "corrected for how many comparisons there are. Take: the fastest, and what may be as fast. "
       "Never: at least twice the time of the fastest, or runs that died."});
  for (const Contest& contest : contests) {
    std::vector<std::string> take, others, never;
    for (const std::size_t at : contest.choices) take.push_back(name_of(findings.cells[at]));
    for (const std::size_t at : contest.never) never.push_back(never_text(findings, contest, at));
    for (const Rival& rival : contest.rivals)
      if (rival.answer != Answer::kUndecided &&
          std::ranges::find(contest.never, rival.cell) == contest.never.end())
        others.push_back(
            fmt::format("{} {}", name_of(findings.cells[rival.cell]), answer_text(rival)));
    const MeasuredCell& first = first_of(contest);
    std::string choice = fmt::format("{}", fmt::join(take, " or "));
    if (!contest.open.empty()) choice += (choice.empty() ? "" : "; ") + contest.open;
    instrument::Table::Row row{{first.disk, first.workload},
                               findings.failed ? Tone::kFailed : Tone::kPlain};
    if (sizes) row.cells.push_back(size_of(first));
    for (std::string& cell : std::array{choice, fmt::format("{}", fmt::join(others, "; ")),
                                        fmt::format("{}", fmt::join(never, "; "))})
      row.cells.push_back(std::move(cell));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<std::string> advice_of(const Findings& findings) {
  struct Disk {
    std::map<std::string, int> good;  ///< how often it is a choice, or equal to one
    std::set<std::string> sizes;
    int all = 0;
  };
  std::map<std::string, Disk> disks;
  for (const Contest& contest : contests_in(findings)) {
    const MeasuredCell& first = findings.cells[contest.cells.front()].cell;
    Disk& disk = disks[first.disk];
    ++disk.all;
    disk.sizes.insert(size_of(first));
    for (const std::size_t at : contest.choices) ++disk.good[findings.cells[at].name];
    for (const Rival& rival : contest.rivals)
      if (rival.answer == Answer::kEqual) ++disk.good[findings.cells[rival.cell].name];
  }
  std::vector<std::string> lines;
  for (const auto& [name, disk] : disks) {
    const auto best =
        std::ranges::max_element(disk.good, {}, [](auto& each) { return each.second; });
    lines.push_back(fmt::format(
        "On {}{}: {}.", name.empty() ? "a disk without a name" : name,
        disk.sizes.size() == 1 && !disk.sizes.begin()->empty() ? ", " + *disk.sizes.begin() : "",
        disk.good.empty() ? "nothing could be ranked"
                          : fmt::format("{} is among the best for {} of {} workloads", best->first,
                                        best->second, disk.all)));
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
  const std::vector<Contest> contests = contests_in(findings);
  if (contests.empty()) return "There is one way only, and nothing to compare it with.";
  std::size_t known = 0, of_two = 0, never = 0;
  for (const Contest& contest : contests) {
    known += contest.is_known();
    of_two += contest.is_known() && contest.choices.size() == 2;
    never += contest.never.size();
  }
  return fmt::format(
      "The choice is known for {} of {} workload{}{}{}.{}", known, contests.size(),
      contests.size() == 1 ? "" : "s",
      of_two == 0 ? "" : fmt::format(", for {} of them as one of two", of_two),
      never == 0 ? ""
                 : fmt::format("; {} choice{} must never be taken", never, never == 1 ? "" : "s"),
      text_about_auto(findings));
}

}  // namespace plait::bench
