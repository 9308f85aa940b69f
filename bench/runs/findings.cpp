#include "runs/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <unordered_map>

#include "base/text.h"
#include "instrument/figure_text.h"
#include "runs/report_page.h"

namespace plait::bench {
namespace {

std::string bytes_text(double bytes) {
  return bytes < 1e18 ? size_text(static_cast<std::uint64_t>(bytes)) : fmt::format("{:.3g}", bytes);
}

/// Options are worth a place in a name only where they differ between the cells of a set.
void add_names(std::vector<CellFigures>& cells) {
  const auto varies = [&](std::optional<double> MeasuredCell::*option) {
    return std::ranges::any_of(cells, [&](const CellFigures& figures) {
      return figures.cell.*option != cells.front().cell.*option;
    });
  };
  // Backends have block sizes of their own, which say nothing.
  const bool block = std::ranges::any_of(cells, [&](const CellFigures& figures) {
    return std::ranges::any_of(cells, [&](const CellFigures& other) {
      return figures.cell.backend == other.cell.backend &&
             figures.cell.block_bytes != other.cell.block_bytes;
    });
  });
  const bool threads = varies(&MeasuredCell::threads), budget = varies(&MeasuredCell::budget);
  for (CellFigures& figures : cells) {
    const MeasuredCell& cell = figures.cell;
    std::string& name = figures.name = way_of(cell);
    if (block && cell.block_bytes)
      name += fmt::format(", blocks of {}", bytes_text(*cell.block_bytes));
    if (threads && cell.threads) name += fmt::format(", {} threads", *cell.threads);
    if (budget && cell.budget) name += fmt::format(", budget {}", bytes_text(*cell.budget));
  }
}

void add_intervals(const RunSet& set, CellFigures& figures) {
  std::vector<double> seconds, ratios;
  for (const std::size_t at : figures.runs) {
    seconds.push_back(set.runs[at].seconds);
    if (set.runs[at].ratio) ratios.push_back(*set.runs[at].ratio);
  }
  figures.seconds = instrument::geometric_interval(seconds);
  if (!ratios.empty()) figures.ratio = instrument::geometric_interval(ratios);
  std::vector<std::size_t> ordered = figures.runs;
  std::ranges::sort(ordered, {}, [&](std::size_t at) { return set.runs[at].seconds; });
  figures.middle = ordered[(ordered.size() - 1) / 2];
}

nlohmann::ordered_json json_of(const std::optional<instrument::Estimate>& estimate) {
  return estimate ? instrument::to_json(*estimate) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json json_of(const CellFigures& figures) {
  nlohmann::ordered_json object = {{"name", figures.name}};
  const MeasuredCell& cell = figures.cell;
  for (const auto& [name, member] : kTextsOfCell) object[name] = cell.*member;
  if (cell.mesh.empty()) object["mesh"] = nullptr;
  for (const auto& [name, member] : kNumbersOfCell)
    object[std::string_view(name) == "ratio" ? "times_memory" : name] = or_null(cell.*member);
  object["durable"] = cell.durable;
  object["label"] = figures.label;
  object["failed"] = figures.failed;
  object["ratio"] = json_of(figures.ratio);
  object["seconds"] = json_of(figures.seconds);
  return object;
}

nlohmann::ordered_json json_of(const Findings& findings, const Contest& contest) {
  constexpr const char* kAnswers[] = {"slower", "equal", "undecided"};
  const auto names_of = [&](const std::vector<std::size_t>& cells) {
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    for (const std::size_t at : cells) names.push_back(findings.cells[at].name);
    return names;
  };
  nlohmann::ordered_json rivals = nlohmann::ordered_json::array();
  for (const Rival& rival : contest.rivals)
    rivals.push_back({{"backend", findings.cells[rival.cell].name},
                      {"answer", kAnswers[static_cast<std::size_t>(rival.answer)]},
                      {"factor", instrument::to_json(rival.factor)},
                      {"more_seconds", or_null(rival.more_seconds)}});
  const CellFigures& first = findings.cells[contest.cells.front()];
  return {{"disk", first.cell.disk},
          {"workload", first.cell.workload},
          {"size", size_of(first.cell)},
          {"known", contest.is_known()},
          {"choices", names_of(contest.choices)},
          {"never", names_of(contest.never)},
          {"open", contest.open},
          {"rivals", std::move(rivals)},
          {"cells", contest.cells}};
}

}  // namespace

std::vector<CellFigures> cells_of(const RunSet& set) {
  std::vector<CellFigures> cells;
  std::unordered_map<std::string, std::size_t> by_key;
  for (std::size_t at = 0; at < set.runs.size(); ++at) {
    const MeasuredRun& run = set.runs[at];
    const auto [place, is_new] = by_key.try_emplace(run.key, cells.size());
    if (is_new) {
      cells.emplace_back().cell = run.cell;
      cells.back().key = run.key;
    }
    CellFigures& figures = cells[place->second];
    figures.is_auto = figures.is_auto || run.is_auto;
    if (!run.ok) {
      ++figures.failed;
      continue;
    }
    figures.runs.push_back(at);
    if (figures.label.empty() || run.label == "warm") figures.label = run.label;
  }
  add_names(cells);
  for (CellFigures& figures : cells)
    if (!figures.runs.empty()) add_intervals(set, figures);
  return cells;
}

std::string survival_of(const CellFigures& figures) {
  if (figures.failed == 0) return {};
  const std::uint64_t all = figures.failed + figures.runs.size();
  return fmt::format("{} of {} survived", figures.runs.size(), all);
}

std::string way_of(const MeasuredCell& cell) {
  return cell.pipeline.empty() || cell.pipeline == "none" ? cell.backend
                                                          : cell.backend + ", " + cell.pipeline;
}

std::string size_of(const MeasuredCell& cell) {
  std::string size;
  if (cell.ratio)
    size = fmt::format("{:.2g} × memory", *cell.ratio);
  else if (cell.vertices)
    size = fmt::format("{:.3g} million vertices", *cell.vertices / 1e6);
  if (cell.mesh.empty()) return size;
  // The checksum at the end of the name is for programs.
  return cell.mesh.substr(0, cell.mesh.rfind(' ')) + (size.empty() ? "" : ", " + size);
}

std::vector<std::string> digest_failures(const std::vector<MeasuredRun>& runs) {
  const auto place_of = [](const MeasuredRun& run) {
    return fmt::format("{}:{} ({}, {})", run.file, run.line, run.cell.workload, run.cell.backend);
  };
  std::map<std::string, const MeasuredRun*> first_with;
  std::vector<std::string> failures;
  for (const MeasuredRun& run : runs) {
    if (run.digest_of.empty() || run.digest.empty() || failures.size() == 10) continue;
    if (run.digest == "torn")
      failures.push_back(
          fmt::format("{} has a slot of the {} that is torn", place_of(run), run.digest_of));
    const MeasuredRun& first = *first_with.try_emplace(run.digest_of, &run).first->second;
    if (first.digest != run.digest)
      failures.push_back(fmt::format("{} has digest {} of {}, but {} has {}", place_of(run),
                                     run.digest, run.digest_of, place_of(first), first.digest));
  }
  return failures;
}

Findings find(const RunSet& set) {
  Findings findings;
  findings.cells = cells_of(set);
  findings.contests = contests_of(set, findings.cells);
  add_doubts(set, findings);
  findings.verdict =
      findings.failed
          ? "FAILED: runs that did the same work left different data, so no figure here counts."
          : verdict_of(findings);
  return findings;
}

nlohmann::ordered_json to_json(const RunSet& set, const Findings& findings) {
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  nlohmann::ordered_json comparisons = nlohmann::ordered_json::array();
  for (const CellFigures& figures : findings.cells) cells.push_back(json_of(figures));
  for (const Contest& contest : findings.contests)
    comparisons.push_back(json_of(findings, contest));
  return {{"verdict", findings.verdict},
          {"advice", advice_of(findings)},
          {"failed", findings.failed},
          {"doubts", findings.doubts},
          {"runs", set.runs.size()},
          {"skipped", set.skipped},
          {"comparisons", std::move(comparisons)},
          {"cells", std::move(cells)}};
}

}  // namespace plait::bench
