// Comparisons for the terminal and as JSON.
#include <fmt/format.h>

#include <algorithm>

#include "bench/comparison.h"

namespace plait::bench {
namespace {

using instrument::Estimate;
using nlohmann::ordered_json;

std::string percent(double factor) { return fmt::format("{:+.1f} %", 100 * (factor - 1)); }

}  // namespace

std::string factor_text(const Estimate& factor) {
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", factor.value, factor.low, factor.high);
}

ordered_json to_json(const Comparison& comparison) {
  const auto json_of = [](const Estimate& factor) {
    return ordered_json{{"value", factor.value},
                        {"low", factor.low},
                        {"high", factor.high},
                        {"confidence", factor.confidence}};
  };
  ordered_json cells = ordered_json::array();
  for (const ComparedCell& cell : comparison.cells)
    cells.push_back({{"name", cell.name},
                     {"figure", cell.figure},
                     {"runs_before", cell.before},
                     {"runs_after", cell.after},
                     {"factor", json_of(cell.factor)},
                     {"p_value", cell.p_value},
                     {"adjusted_p_value", cell.adjusted},
                     {"differs", cell.differs},
                     {"regression", cell.regression}});
  return {{"verdict", comparison.verdict},
          {"passes", comparison.passes()},
          {"failed", comparison.failed},
          {"regression", comparison.regression},
          {"threshold", comparison.threshold},
          {"factor", comparison.factor ? json_of(*comparison.factor) : ordered_json(nullptr)},
          {"p_value", comparison.p_value},
          {"doubts", comparison.doubts},
          {"cells", std::move(cells)}};
}

std::string to_text(const Comparison& comparison) {
  std::string text =
      fmt::format("{:>26}  {:>8}  {:>7}  {:<11}  {}\n", "B over A (95 %)", "p", "runs", "", "cell");
  std::vector<const ComparedCell*> ordered;
  for (const ComparedCell& cell : comparison.cells) ordered.push_back(&cell);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const ComparedCell* a, const ComparedCell* b) {
                     return a->factor.value > b->factor.value;
                   });
  for (const ComparedCell* cell : ordered)
    text += fmt::format("{:>26}  {:>8.2g}  {:>7}  {:<11}  {}\n", factor_text(cell->factor),
                        cell->adjusted, fmt::format("{}/{}", cell->before, cell->after),
                        cell->regression ? "REGRESSION"
                        : cell->differs  ? percent(cell->factor.value)
                                         : "undecided",
                        cell->name);
  text += "\n" + comparison.verdict + "\n";
  if (!comparison.doubts.empty()) text += "doubts:\n";
  for (const std::string& doubt : comparison.doubts) text += "  - " + doubt + "\n";
  for (char& character : text)  // names come from foreign files
    if ((static_cast<unsigned char>(character) < 0x20 && character != '\n') || character == 0x7f)
      character = '?';
  return text;
}

}  // namespace plait::bench
