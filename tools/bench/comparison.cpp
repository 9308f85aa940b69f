#include "bench/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plait/error.h"

namespace plait::bench {
namespace {

using instrument::Estimate;

constexpr double kSignificant = 0.05;

struct Side {
  std::vector<const MeasuredRun*> runs;  ///< that succeeded
  std::uint64_t failed = 0;
};

std::map<std::string, Side> sides_of(const RunSet& set) {
  std::map<std::string, Side> sides;
  for (const MeasuredRun& run : set.runs) {
    Side& side = sides[run.key];
    if (run.ok)
      side.runs.push_back(&run);
    else
      ++side.failed;
  }
  return sides;
}

/// The runs with this label: cold and warm figures have nothing to do with each other.
std::vector<const MeasuredRun*> labelled(const std::vector<const MeasuredRun*>& runs,
                                         const std::string& label) {
  std::vector<const MeasuredRun*> result;
  for (const MeasuredRun* run : runs)
    if (run->label == label) result.push_back(run);
  return result;
}

std::vector<double> figures_of(const std::vector<const MeasuredRun*>& runs, bool ratios) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const MeasuredRun* run : runs)
    values.push_back(ratios ? run->ratio.value_or(0) : run->seconds);
  return values;
}

std::string full_name(const MeasuredCell& cell) {
  std::string name = work_of(cell);
  for (const std::string& part : {size_of(cell), cell.disk, cell.backend})
    if (!part.empty()) name += ", " + part;
  if (!cell.pipeline.empty() && cell.pipeline != "none") name += ", " + cell.pipeline;
  return name;
}

void compare_cell(const Side& before, const Side& after, Comparison& comparison) {
  const std::string name = full_name((before.runs.empty() ? after : before).runs.front()->cell);
  if (after.failed > 0 && before.failed == 0) {
    comparison.failed = true;
    comparison.doubts.push_back(
        fmt::format("FAILED: {}: {} runs of B failed, and none of A", name, after.failed));
  }
  if (before.runs.empty() || after.runs.empty()) return;
  const std::string label = before.runs.front()->label;
  const auto first = labelled(before.runs, label);
  const auto second = labelled(after.runs, label);
  if (first.size() < before.runs.size() || second.size() < after.runs.size())
    comparison.doubts.push_back(
        fmt::format("{}: only the runs that are '{}' were compared", name, label));
  if (second.empty()) return;
  const auto has_ratio = [](const MeasuredRun* run) { return run->ratio.has_value(); };
  const bool ratios = std::all_of(first.begin(), first.end(), has_ratio) &&
                      std::all_of(second.begin(), second.end(), has_ratio);
  const std::vector<double> a = figures_of(first, ratios);
  const std::vector<double> b = figures_of(second, ratios);
  ComparedCell cell;
  cell.name = name;
  cell.figure = ratios ? "ratio" : "seconds";
  cell.before = a.size();
  cell.after = b.size();
  cell.factor = instrument::factor_interval(a, b);
  cell.p_value = instrument::mann_whitney(a, b).p_value;
  comparison.cells.push_back(std::move(cell));
}

void judge_cells(Comparison& comparison) {
  std::vector<double> p_values;
  for (const ComparedCell& cell : comparison.cells) p_values.push_back(cell.p_value);
  const std::vector<double> adjusted = instrument::adjusted_p_values(p_values);
  for (std::size_t at = 0; at < comparison.cells.size(); ++at) {
    ComparedCell& cell = comparison.cells[at];
    cell.adjusted = adjusted[at];
    cell.differs = cell.adjusted <= kSignificant;
    cell.regression = cell.differs && cell.factor.value > 1 + comparison.threshold;
    comparison.regression |= cell.regression;
  }
}

void judge_all(Comparison& comparison) {
  if (comparison.cells.size() < 2) return;
  std::vector<double> logarithms;
  for (const ComparedCell& cell : comparison.cells)
    logarithms.push_back(std::log(cell.factor.value));
  logarithms.resize(std::min(logarithms.size(), instrument::kMostValues));
  Estimate factor = instrument::pseudo_median_interval(logarithms);
  factor.value = std::exp(factor.value);
  factor.low = std::exp(factor.low);
  factor.high = std::exp(factor.high);
  comparison.factor = factor;
  comparison.p_value = instrument::wilcoxon_signed_rank(logarithms).p_value;
  comparison.differs = comparison.p_value <= kSignificant;
  comparison.regression |= comparison.differs && factor.value > 1 + comparison.threshold;
}

std::string verdict_of(const Comparison& comparison) {
  if (comparison.failed) return "FAILED: B did not do the same work as A.";
  const auto slower = std::count_if(comparison.cells.begin(), comparison.cells.end(),
                                    [](const ComparedCell& cell) { return cell.regression; });
  const auto different = std::count_if(comparison.cells.begin(), comparison.cells.end(),
                                       [](const ComparedCell& cell) { return cell.differs; });
  const std::string all = comparison.factor ? fmt::format(", over all by a factor of {}",
                                                          factor_text(*comparison.factor))
                                            : std::string();
  if (comparison.regression)
    return fmt::format("Regression: B is slower than A by more than {:.3g} % in {} of {} cells{}.",
                       100 * comparison.threshold, slower, comparison.cells.size(), all);
  if (different == 0 && !comparison.differs)
    return fmt::format("No difference shown in {} cell{}{}.", comparison.cells.size(),
                       comparison.cells.size() == 1 ? "" : "s", all);
  return fmt::format(
      "No regression: {} of {} cells differ{}; none is slower by more than {:.3g} %.", different,
      comparison.cells.size(), all, 100 * comparison.threshold);
}

/// Small samples cannot show a difference in one cell among many, however large it is.
void add_doubt_of_power(Comparison& comparison) {
  std::size_t blind = 0;
  for (const ComparedCell& cell : comparison.cells) {
    const double a = static_cast<double>(cell.before);
    const double b = static_cast<double>(cell.after);
    const double least =
        2 * std::exp(std::lgamma(a + 1) + std::lgamma(b + 1) - std::lgamma(a + b + 1));
    blind += least * static_cast<double>(comparison.cells.size()) > kSignificant;
  }
  if (blind > 0)
    comparison.doubts.push_back(fmt::format(
        "{} of {} cells have too few rounds to show a difference alone among so many cells", blind,
        comparison.cells.size()));
}

}  // namespace

Comparison compare(const RunSet& before, const RunSet& after, double threshold) {
  Comparison comparison;
  comparison.threshold = threshold;
  const std::map<std::string, Side> first = sides_of(before);
  const std::map<std::string, Side> second = sides_of(after);
  std::size_t shared = 0;
  for (const auto& [key, side] : first) {
    const auto other = second.find(key);
    if (other == second.end()) continue;
    ++shared;
    if (side.runs.empty() && other->second.runs.empty()) continue;
    compare_cell(side, other->second, comparison);
  }
  if (shared == 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("compare {} and {}: expected a cell that both measured, found none",
                            before.runs.front().file, after.runs.front().file));
  if (const std::size_t alone = first.size() + second.size() - 2 * shared; alone > 0)
    comparison.doubts.push_back(fmt::format("{} cells are in one of the two only", alone));
  std::vector<MeasuredRun> all = before.runs;
  all.insert(all.end(), after.runs.begin(), after.runs.end());
  for (const std::string& failure : digest_failures(all)) {
    comparison.failed = true;
    comparison.doubts.push_back("FAILED: " + failure);
  }
  judge_cells(comparison);
  judge_all(comparison);
  add_doubt_of_power(comparison);
  if (before.skipped + after.skipped > 0)
    comparison.doubts.push_back(
        fmt::format("{} lines are no records and were skipped", before.skipped + after.skipped));
  comparison.verdict = verdict_of(comparison);
  return comparison;
}

}  // namespace plait::bench
