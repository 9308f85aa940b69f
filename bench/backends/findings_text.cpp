// Findings for the terminal and as JSON.
#include <fmt/format.h>

#include "backends/findings.h"
#include "backends/first_screen.h"
#include "backends/report_page.h"
#include "instrument/figure_text.h"

namespace plait::bench {
namespace {

using instrument::printable;
using instrument::wrapped;
using nlohmann::ordered_json;

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const std::optional<instrument::Estimate>& estimate) {
  return estimate ? instrument::to_json(*estimate) : ordered_json(nullptr);
}

ordered_json json_of(const Findings& findings, const Rival& rival) {
  const char* const answers[] = {"slower", "equal", "undecided"};
  return {{"backend", findings.cells[rival.cell].name},
          {"answer", answers[static_cast<std::size_t>(rival.answer)]},
          {"factor", json_of(std::optional(rival.factor))},
          {"more_seconds", json_of(rival.more_seconds)}};
}

}  // namespace

ordered_json to_json(const RunSet& set, const Findings& findings) {
  ordered_json cells = ordered_json::array();
  for (const CellFigures& figures : findings.cells) {
    const MeasuredCell& cell = figures.cell;
    cells.push_back({{"name", figures.name},
                     {"backend", cell.backend},
                     {"pipeline", cell.pipeline},
                     {"disk", cell.disk},
                     {"workload", cell.workload},
                     {"mesh", cell.mesh.empty() ? ordered_json(nullptr) : ordered_json(cell.mesh)},
                     {"vertices", json_of(cell.vertices)},
                     {"levels", json_of(cell.levels)},
                     {"memory", json_of(cell.memory)},
                     {"budget", json_of(cell.budget)},
                     {"times_memory", json_of(cell.ratio)},
                     {"block_bytes", json_of(cell.block_bytes)},
                     {"threads", json_of(cell.threads)},
                     {"rate", json_of(cell.rate)},
                     {"durable", cell.durable},
                     {"label", figures.label},
                     {"failed", figures.failed},
                     {"ratio", json_of(figures.ratio)},
                     {"seconds", json_of(figures.seconds)}});
  }
  ordered_json comparisons = ordered_json::array();
  for (const Contest& contest : findings.contests) {
    const CellFigures& first = findings.cells[contest.cells.front()];
    ordered_json rivals = ordered_json::array();
    for (const Rival& rival : contest.rivals) rivals.push_back(json_of(findings, rival));
    comparisons.push_back(
        {{"disk", first.cell.disk},
         {"workload", work_of(first.cell)},
         {"size", size_of(first.cell)},
         {"decided", contest.decided},
         {"fastest", contest.decided ? ordered_json(first.name) : ordered_json(nullptr)},
         {"rivals", std::move(rivals)},
         {"why_not", contest.why_not},
         {"cells", contest.cells}});
  }
  return {{"verdict", findings.verdict}, {"failed", findings.failed},
          {"doubts", findings.doubts},   {"runs", set.runs.size()},
          {"skipped", set.skipped},      {"comparisons", std::move(comparisons)},
          {"cells", std::move(cells)}};
}

std::string to_text(const RunSet& set, const Findings& findings) {
  constexpr std::size_t kWidth = 118;
  /// More cells than a screen has lines are on the page and in the JSON only.
  constexpr std::size_t kMostCells = 40;
  const auto line_of = [](const std::string& text) {
    return wrapped("- " + printable(text), kWidth, "  ");
  };
  std::string text;
  if (findings.failed) text += findings.verdict + "\n";
  for (std::size_t at = 0; at < findings.spoiling; ++at) text += line_of(findings.doubts[at]);
  if (!text.empty()) text += "\n";
  if (const instrument::Table matrix = matrix_table(findings); !matrix.rows.empty())
    text += to_text(matrix) + "\n";
  if (!findings.failed) text += wrapped(printable(findings.verdict), kWidth);
  if (findings.spoiling < findings.doubts.size()) text += "doubts:\n";
  for (std::size_t at = findings.spoiling; at < findings.doubts.size(); ++at)
    text += line_of(findings.doubts[at]);
  if (findings.cells.size() > kMostCells)
    return text + fmt::format("the figures of {} cells are on the page (--html) and in --json\n",
                              findings.cells.size());
  return fmt::format(
      "{}\n{}ratio: seconds over those of the floor, the same bytes moved by a plain program; {} "
      "runs\n",
      text, to_text(figures_table(set, findings)), set.runs.size());
}

}  // namespace plait::bench
