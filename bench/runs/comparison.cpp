#include "runs/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "instrument/figure_text.h"
#include "instrument/page.h"
#include "plait/error.h"

namespace plait::bench {
namespace {

constexpr double kConfidence = 0.95;
constexpr const char* kAllCells = "all cells";
/// The interval of two cells would span a dozen powers of ten.
constexpr std::size_t kFewestOfStratum = 3;

/// The runs with this label: cold and warm figures have nothing to do with each other.
std::vector<const MeasuredRun*> labelled(const RunSet& set, const CellFigures& cell,
                                         const std::string& label) {
  std::vector<const MeasuredRun*> result;
  for (const std::size_t at : cell.runs)
    if (set.runs[at].label == label) result.push_back(&set.runs[at]);
  return result;
}

std::string full_name(const MeasuredCell& cell) {
  std::string name = cell.workload;
  for (const std::string& part : {size_of(cell), cell.disk, way_of(cell)})
    if (!part.empty()) name += ", " + part;
  return name;
}

/// A shift whose interval waits until it is known how many there are.
struct Pending {
  Shift shift;
  std::vector<double> before, after;  ///< of a stratum: factors and nothing
  instrument::Comparison compare(double confidence) const {
    return after.empty() ? instrument::compare_with_one(before, confidence)
                         : instrument::compare_unpaired(before, after, confidence);
  }
};

/// Collects the shifts of cells, and of the strata to which they belong.
class Shifts {
 public:
  Shifts(const RunSet& before, const RunSet& after) : before_(before), after_(after) {}

  void add(const CellFigures& before, const CellFigures& after, SetComparison& comparison) {
    const std::string name = full_name(before.cell);
    if (after.failed > 0 && before.failed == 0) {
      comparison.failed = true;
      comparison.doubts.push_back(
          fmt::format("FAILED: {}: {} runs of B failed, and none of A", name, after.failed));
    }
    if (before.runs.empty() || after.runs.empty()) return;
    const std::string label = before_.runs[before.runs.front()].label;
    const auto first = labelled(before_, before, label), second = labelled(after_, after, label);
    if (first.size() < before.runs.size() || second.size() < after.runs.size())
      comparison.doubts.push_back(
          fmt::format("{}: only the runs that are '{}' were compared", name, label));
    if (second.empty()) return;
    const auto has_ratio = [](const MeasuredRun* run) { return run->ratio.has_value(); };
    const bool ratios =
        std::ranges::all_of(first, has_ratio) && std::ranges::all_of(second, has_ratio);
    const auto figures_of = [&](const std::vector<const MeasuredRun*>& runs) {
      std::vector<double> values;
      values.reserve(runs.size());
      for (const MeasuredRun* run : runs) values.push_back(ratios ? *run->ratio : run->seconds);
      return values;
    };
    Pending& pending = pending_.emplace_back();
    pending.before = figures_of(first);
    pending.after = figures_of(second);
    pending.shift.name = name;
    pending.shift.figure = ratios ? "ratio" : "seconds";
    pending.shift.before = first.size();
    pending.shift.after = second.size();
    for (const std::string& stratum :
         {std::string(kAllCells), "backend " + way_of(before.cell),
          "workload " + before.cell.workload, "disk " + before.cell.disk})
      strata_[stratum].push_back(pending.compare(kConfidence).factor.value);
  }

  /// Adjusts all for each other, with the intervals that say the same. They are one family: a shift
  /// of a stratum is one more chance to be wrong.
  void judge(SetComparison& comparison) {
    for (const auto& [name, factors] : strata_) {
      if (factors.size() < kFewestOfStratum) continue;
      Pending& pending = pending_.emplace_back();
      pending.before = factors;
      pending.shift.name = name;
      pending.shift.cells = factors.size();
    }
    std::vector<double> p_values;
    for (const Pending& each : pending_) p_values.push_back(each.compare(kConfidence).p_value);
    const std::vector<double> adjusted = instrument::adjusted_p_values(p_values);
    const double confidence = instrument::confidence_among(p_values, 1 - kConfidence);
    for (std::size_t at = 0; at < pending_.size(); ++at) {
      Shift& shift = pending_[at].shift;
      shift.factor = pending_[at].compare(confidence).factor;
      shift.p_value = p_values[at];
      shift.adjusted = adjusted[at];
      shift.differs = shift.adjusted <= 1 - kConfidence;
      shift.regression = shift.differs && shift.factor.value > 1 + comparison.threshold;
      comparison.regression = comparison.regression || shift.regression;
      (shift.cells == 1 ? comparison.cells : comparison.strata).push_back(std::move(shift));
    }
  }

 private:
  const RunSet& before_;
  const RunSet& after_;
  std::vector<Pending> pending_;
  std::map<std::string, std::vector<double>> strata_;  ///< factors
};

/// "B takes 9 to 12 % longer", "B takes 3 to 5 % less time", "B takes between 2 % less and 1 % more
/// time".
std::string shift_text(const instrument::Estimate& factor) {
  // Tenths where whole numbers would say "0 to 0".
  const auto percent = [&](double share) {
    return fmt::format("{:.{}f}", 100 * share, factor.high - factor.low < 0.02 ? 1 : 0);
  };
  if (factor.low > 1)
    return fmt::format("B takes {} to {} % longer", percent(factor.low - 1),
                       percent(factor.high - 1));
  if (factor.high < 1)
    return fmt::format("B takes {} to {} % less time", percent(1 - factor.high),
                       percent(1 - factor.low));
  return fmt::format("B takes between {} % less and {} % more time", percent(1 - factor.low),
                     percent(factor.high - 1));
}

std::string verdict_of(const SetComparison& comparison) {
  if (comparison.failed) return "FAILED: B did not do the same work as A.";
  std::string all, slower;
  std::size_t named = 0;
  for (const Shift& shift : comparison.strata) {
    const std::string text = shift_text(shift.factor);
    const bool is_all = shift.name == kAllCells;
    const std::string where =
        is_all ? fmt::format("{} over all {} cells", text, shift.cells)
               : fmt::format("{} in {} ({} cells)", text, shift.name, shift.cells);
    if (is_all) all = where + ". ";
    if (shift.regression && ++named <= 4) slower += where + "; ";
  }
  const std::size_t cells = comparison.cells.size();
  if (comparison.regression)
    return fmt::format("Regression by more than {:.3g} %: {}{}{} of {} single cells.",
                       100 * comparison.threshold, slower, slower.empty() ? "" : "and ",
                       std::ranges::count_if(comparison.cells, &Shift::regression), cells);
  const auto different = std::ranges::count_if(comparison.cells, &Shift::differs);
  const auto strata = std::ranges::count_if(comparison.strata, &Shift::differs);
  if (different + strata == 0)
    return fmt::format("No difference shown in {} cell{}. {}", cells, cells == 1 ? "" : "s", all);
  return fmt::format(
      "No regression by more than {:.3g} % shown: {} of {} cells and {} of {} strata differ. {}",
      100 * comparison.threshold, different, cells, strata, comparison.strata.size(), all);
}

nlohmann::ordered_json json_of(const std::vector<Shift>& shifts) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Shift& shift : shifts)
    list.push_back({{"name", shift.name},
                    {"figure", shift.figure},
                    {"cells", shift.cells},
                    {"runs_before", shift.before},
                    {"runs_after", shift.after},
                    {"factor", instrument::to_json(shift.factor)},
                    {"p_value", shift.p_value},
                    {"adjusted_p_value", shift.adjusted},
                    {"differs", shift.differs},
                    {"regression", shift.regression}});
  return list;
}

/// The slowest first.
instrument::Table table_of(std::vector<Shift> shifts, const char* what) {
  std::ranges::stable_sort(shifts, std::ranges::greater(),
                           [](const Shift& shift) { return shift.factor.value; });
  instrument::Table table = instrument::table_with(fmt::format("#B over A|#interval||{}", what));
  for (const Shift& shift : shifts)
    table.rows.push_back({{fmt::format("{:.3f}", shift.factor.value),
                           fmt::format("{:.3f} to {:.3f}", shift.factor.low, shift.factor.high),
                           shift.regression ? "REGRESSION"
                           : shift.differs  ? "differs"
                                            : "undecided",
                           shift.cells > 1 ? fmt::format("{} ({} cells)", shift.name, shift.cells)
                                           : fmt::format("{} ({}/{} runs)", shift.name,
                                                         shift.before, shift.after)}});
  return table;
}

}  // namespace

SetComparison compare(const RunSet& before, const RunSet& after, double threshold) {
  SetComparison comparison;
  comparison.threshold = threshold;
  Shifts shifts(before, after);
  std::map<std::string, CellFigures> second;
  for (CellFigures& cell : cells_of(after)) second.emplace(cell.key, std::move(cell));
  const std::vector<CellFigures> first = cells_of(before);
  std::size_t shared = 0;
  for (const CellFigures& cell : first)
    if (const auto other = second.find(cell.key); other != second.end()) {
      ++shared;
      shifts.add(cell, other->second, comparison);
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
  shifts.judge(comparison);
  if (before.skipped + after.skipped > 0)
    comparison.doubts.push_back(
        fmt::format("{} lines are no records and were skipped", before.skipped + after.skipped));
  comparison.verdict = verdict_of(comparison);
  return comparison;
}

nlohmann::ordered_json to_json(const SetComparison& comparison) {
  return {{"verdict", comparison.verdict},        {"passes", comparison.passes()},
          {"failed", comparison.failed},          {"regression", comparison.regression},
          {"threshold", comparison.threshold},    {"doubts", comparison.doubts},
          {"strata", json_of(comparison.strata)}, {"cells", json_of(comparison.cells)}};
}

std::string to_text(const SetComparison& comparison) {
  using instrument::Tone;
  instrument::Page page;
  if (!comparison.strata.empty()) page.add(table_of(comparison.strata, "stratum"));
  page.add(table_of(comparison.cells, "cell"));
  page.add(instrument::Verdict{comparison.verdict, Tone::kPlain});
  page.add(instrument::List{comparison.doubts, Tone::kDoubt});
  return to_text(page);
}

}  // namespace plait::bench
