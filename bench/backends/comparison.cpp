#include "backends/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "plait/error.h"

namespace plait::bench {
namespace {

constexpr double kConfidence = 0.95;

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

/// Where a cell belongs.
std::vector<std::string> strata_of(const MeasuredCell& cell) {
  std::string backend = "backend " + cell.backend;
  if (!cell.pipeline.empty() && cell.pipeline != "none") backend += ", " + cell.pipeline;
  return {"all cells", backend, "workload " + work_of(cell), "disk " + cell.disk};
}

using Strata = std::map<std::string, std::vector<double>>;

/// The interval of two cells would span a dozen powers of ten.
constexpr std::size_t kFewestOfStratum = 3;

/// A shift whose interval waits until it is known how many there are.
struct Pending {
  Shift shift;
  std::function<instrument::Comparison(double confidence)> compare;
};

void compare_cell(const Side& before, const Side& after, SetComparison& comparison,
                  std::vector<Pending>& cells, Strata& strata) {
  const MeasuredCell& what = (before.runs.empty() ? after : before).runs.front()->cell;
  const std::string name = full_name(what);
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
  Shift cell;
  cell.name = name;
  cell.figure = ratios ? "ratio" : "seconds";
  cell.before = a.size();
  cell.after = b.size();
  const auto compare = [=](double confidence) {
    return instrument::compare_unpaired(a, b, confidence);
  };
  const double factor = compare(kConfidence).factor.value;
  for (const std::string& stratum : strata_of(what)) strata[stratum].push_back(factor);
  cells.push_back({std::move(cell), compare});
}

std::vector<Pending> compare_strata(const Strata& strata) {
  std::vector<Pending> shifts;
  for (const auto& [name, factors] : strata) {
    if (factors.size() < kFewestOfStratum) continue;
    Shift stratum;
    stratum.name = name;
    stratum.cells = factors.size();
    shifts.push_back({std::move(stratum), [ratios = factors](double confidence) {
                        return instrument::compare_with_one(ratios, confidence);
                      }});
  }
  return shifts;
}

/// Adjusts the shifts of a list for each other, with the intervals that say the same.
std::vector<Shift> judged(std::vector<Pending> shifts, double threshold) {
  std::vector<double> p_values;
  p_values.reserve(shifts.size());
  for (const Pending& each : shifts) p_values.push_back(each.compare(kConfidence).p_value);
  const std::vector<double> adjusted = instrument::adjusted_p_values(p_values);
  const double confidence = instrument::confidence_among(p_values, 1 - kConfidence);
  std::vector<Shift> result;
  for (std::size_t at = 0; at < shifts.size(); ++at) {
    Shift& shift = result.emplace_back(std::move(shifts[at].shift));
    shift.factor = shifts[at].compare(confidence).factor;
    shift.p_value = p_values[at];
    shift.adjusted = adjusted[at];
    shift.differs = shift.adjusted <= 1 - kConfidence;
    shift.regression = shift.differs && shift.factor.value > 1 + threshold;
  }
  return result;
}

std::string verdict_of(const SetComparison& comparison) {
  if (comparison.failed) return "FAILED: B did not do the same work as A.";
  const auto count = [](const std::vector<Shift>& shifts, bool Shift::*is) {
    return std::ranges::count_if(shifts, is);
  };
  const auto in = [](const Shift& shift) {
    return shift.name == "all cells"
               ? fmt::format("{} over all {} cells", shift_text(shift.factor), shift.cells)
               : fmt::format("{} in {} ({} cells)", shift_text(shift.factor), shift.name,
                             shift.cells);
  };
  std::string all, slower;
  std::size_t named = 0;
  for (const Shift& shift : comparison.strata) {
    if (shift.name == "all cells") all = in(shift) + ". ";
    if (shift.regression && ++named <= 4) slower += (slower.empty() ? "" : "; ") + in(shift);
  }
  const auto cells = count(comparison.cells, &Shift::regression);
  if (comparison.regression)
    return fmt::format("Regression by more than {:.3g} %: {}{}{} of {} single cells.",
                       100 * comparison.threshold, slower, slower.empty() ? "" : "; and ", cells,
                       comparison.cells.size());
  const auto different = count(comparison.cells, &Shift::differs);
  const auto strata = count(comparison.strata, &Shift::differs);
  if (different + strata == 0)
    return fmt::format("No difference shown in {} cell{}. {}", comparison.cells.size(),
                       comparison.cells.size() == 1 ? "" : "s", all);
  return fmt::format(
      "No regression by more than {:.3g} % shown: {} of {} cells and {} of {} strata "
      "differ. {}",
      100 * comparison.threshold, different, comparison.cells.size(), strata,
      comparison.strata.size(), all);
}

}  // namespace

SetComparison compare(const RunSet& before, const RunSet& after, double threshold) {
  SetComparison comparison;
  std::vector<Pending> cells;
  Strata strata;
  comparison.threshold = threshold;
  const std::map<std::string, Side> first = sides_of(before);
  const std::map<std::string, Side> second = sides_of(after);
  std::size_t shared = 0;
  for (const auto& [key, side] : first) {
    const auto other = second.find(key);
    if (other == second.end()) continue;
    ++shared;
    if (side.runs.empty() && other->second.runs.empty()) continue;
    compare_cell(side, other->second, comparison, cells, strata);
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
  // One family: a shift of a stratum is one more chance to be wrong.
  const std::size_t single = cells.size();
  for (Pending& stratum : compare_strata(strata)) cells.push_back(std::move(stratum));
  comparison.cells = judged(std::move(cells), threshold);
  const auto first_stratum = comparison.cells.begin() + static_cast<std::ptrdiff_t>(single);
  comparison.strata.assign(first_stratum, comparison.cells.end());
  comparison.cells.erase(first_stratum, comparison.cells.end());
  comparison.regression = std::ranges::any_of(comparison.cells, &Shift::regression) ||
                          std::ranges::any_of(comparison.strata, &Shift::regression);
  if (before.skipped + after.skipped > 0)
    comparison.doubts.push_back(
        fmt::format("{} lines are no records and were skipped", before.skipped + after.skipped));
  comparison.verdict = verdict_of(comparison);
  return comparison;
}

}  // namespace plait::bench
