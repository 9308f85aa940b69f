// Comparisons for the terminal and as JSON.
#include <fmt/format.h>

#include <algorithm>

#include "backends/comparison.h"
#include "instrument/figure_text.h"
#include "instrument/page.h"

namespace plait::bench {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const Shift& shift) {
  return {{"name", shift.name},        {"figure", shift.figure},
          {"cells", shift.cells},      {"runs_before", shift.before},
          {"runs_after", shift.after}, {"factor", instrument::to_json(shift.factor)},
          {"p_value", shift.p_value},  {"adjusted_p_value", shift.adjusted},
          {"differs", shift.differs},  {"regression", shift.regression}};
}

ordered_json json_of(const std::vector<Shift>& shifts) {
  ordered_json list = ordered_json::array();
  for (const Shift& shift : shifts) list.push_back(json_of(shift));
  return list;
}

/// The slowest first.
instrument::Table table_of(std::vector<Shift> shifts, const char* what) {
  std::ranges::stable_sort(
      shifts, [](const Shift& a, const Shift& b) { return a.factor.value > b.factor.value; });
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

ordered_json to_json(const SetComparison& comparison) {
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
