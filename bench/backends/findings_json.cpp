// Findings as JSON.
#include "backends/findings.h"
#include "backends/first_screen.h"
#include "instrument/figure_text.h"

namespace plait::bench {
namespace {

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
         {"backend", contest.decided || contest.backend_decided ? ordered_json(first.cell.backend)
                                                                : ordered_json(nullptr)},
         {"fastest", contest.decided ? ordered_json(first.name) : ordered_json(nullptr)},
         {"rivals", std::move(rivals)},
         {"why_not", contest.why_not},
         {"cells", contest.cells}});
  }
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
