#include "backends/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <unordered_map>

#include "backends/first_screen.h"
#include "base/byte_text.h"

namespace plait::bench {
namespace {

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

}  // namespace

std::vector<CellFigures> cells_of(const RunSet& set) {
  std::vector<CellFigures> cells;
  std::unordered_map<std::string, std::size_t> by_key;
  for (std::size_t at = 0; at < set.runs.size(); ++at) {
    const MeasuredRun& run = set.runs[at];
    const auto [place, is_new] = by_key.try_emplace(run.key, cells.size());
    if (is_new) {
      cells.emplace_back();
      cells.back().cell = run.cell;
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
    figures.seconds = instrument::geometric_interval(seconds);
    const std::vector<double> ratios = values_of(set, figures.runs, &MeasuredRun::ratio);
    if (!ratios.empty()) figures.ratio = instrument::geometric_interval(ratios);
  }
  return cells;
}

std::string survival_of(const CellFigures& figures) {
  if (figures.failed == 0) return {};
  const std::uint64_t all = figures.failed + figures.runs.size();
  return fmt::format("{} of {} survived", figures.runs.size(), all);
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

std::string work_of(const MeasuredCell& cell) {
  std::string work = cell.workload;
  if (cell.rate) work += fmt::format(" at {:g}/s", *cell.rate);
  return work;
}

std::vector<std::string> digest_failures(const std::vector<MeasuredRun>& runs) {
  std::map<std::string, const MeasuredRun*> first_with;
  std::vector<std::string> failures;
  for (const MeasuredRun& run : runs) {
    if (run.digest_of.empty() || run.digest.empty() || failures.size() == 10) continue;
    if (run.digest == "torn")
      failures.push_back(fmt::format("{}:{} ({}, {}) has a slot of the {} that is torn", run.file,
                                     run.line, run.cell.workload, run.cell.backend, run.digest_of));
    const auto [place, is_new] = first_with.try_emplace(run.digest_of, &run);
    const MeasuredRun& first = *place->second;
    if (first.digest == run.digest) continue;
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
  const DoubtLines doubts = doubts_of(set, findings.cells);
  findings.doubts.insert(findings.doubts.end(), doubts.spoiling.begin(), doubts.spoiling.end());
  findings.spoiling = findings.doubts.size();
  findings.doubts.insert(findings.doubts.end(), doubts.others.begin(), doubts.others.end());
  return findings;
}

}  // namespace plait::bench
