// Findings for the terminal and as JSON.
#include <fmt/format.h>

#include <algorithm>

#include "bench/findings.h"

namespace plait::bench {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json json_of(const std::optional<instrument::Estimate>& estimate) {
  if (!estimate) return nullptr;
  return {{"median", estimate->value},
          {"low", estimate->low},
          {"high", estimate->high},
          {"confidence", estimate->confidence},
          {"rounds", estimate->count}};
}

std::string seconds_text(double seconds) {
  if (seconds >= 1) return fmt::format("{:.2f} s", seconds);
  if (seconds >= 1e-3) return fmt::format("{:.2f} ms", seconds * 1e3);
  return fmt::format("{:.2f} us", seconds * 1e6);
}

/// Columns as wide as their widest cell. Widths count characters and not bytes.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  const auto width_of = [](const std::string& text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char character) {
      return (static_cast<unsigned char>(character) & 0xc0) != 0x80;
    }));
  };
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t at = 0; at < row.size(); ++at)
      widths[at] = std::max(widths[at], width_of(row[at]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t at = 0; at < row.size(); ++at)
      line += row[at] + std::string(widths[at] - width_of(row[at]) + 2, ' ');
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

/// Names come from foreign files: what moves a terminal's cursor is not printed.
std::string printable(std::string text) {
  for (char& character : text)
    if (static_cast<unsigned char>(character) < 0x20 || character == 0x7f) character = '?';
  return text;
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
    comparisons.push_back(
        {{"disk", first.cell.disk},
         {"workload", work_of(first.cell)},
         {"size", size_of(first.cell)},
         {"decided", contest.decided},
         {"fastest", contest.decided ? ordered_json(first.name) : ordered_json(nullptr)},
         {"lead", contest.ranked > 1 ? ordered_json(contest.lead) : ordered_json(nullptr)},
         {"why_not", contest.why_not},
         {"cells", contest.cells}});
  }
  return {{"verdict", findings.verdict}, {"failed", findings.failed},
          {"doubts", findings.doubts},   {"runs", set.runs.size()},
          {"skipped", set.skipped},      {"comparisons", std::move(comparisons)},
          {"cells", std::move(cells)}};
}

std::string to_text(const RunSet& set, const Findings& findings) {
  std::vector<std::vector<std::string>> rows = {{"ratio", "95 %", "seconds", "MB/s", "p99",
                                                 "rounds", "backend", "workload", "size", "disk",
                                                 "state"}};
  for (const Contest& contest : findings.contests)
    for (std::size_t place = 0; place < contest.cells.size(); ++place) {
      const CellFigures& figures = findings.cells[contest.cells[place]];
      std::vector<std::string> row = {"-", "-", "-",
                                      "-", "-", fmt::format("{}", figures.runs.size())};
      if (figures.ratio) {
        row[0] = fmt::format("{:.2f}", figures.ratio->value);
        row[1] = fmt::format("{:.2f}-{:.2f}", figures.ratio->low, figures.ratio->high);
      }
      if (figures.seconds) {
        row[2] = seconds_text(figures.seconds->value);
        const MeasuredRun& run = set.runs[figures.middle];
        const double needed = run.needed_read.value_or(0) + run.needed_written.value_or(0);
        if (needed > 0) row[3] = fmt::format("{:.0f}", 1e-6 * needed / run.seconds);
        if (run.p99) row[4] = seconds_text(*run.p99);
      }
      row.push_back(printable(figures.name));
      row.push_back(printable(work_of(figures.cell)));
      row.push_back(size_of(figures.cell));
      row.push_back(printable(figures.cell.disk));
      std::string state = printable(figures.label);
      if (place == 0 && contest.decided) state += ", fastest";
      if (place == 0 && !contest.decided && contest.cells.size() > 1) state += ", undecided";
      if (figures.failed > 0) state += fmt::format(", {} failed", figures.failed);
      if (state.starts_with(", ")) state.erase(0, 2);  // a write is neither cold nor warm
      row.push_back(state);
      rows.push_back(std::move(row));
    }
  const auto line_of = [](const std::string& doubt) {
    return fmt::format("  - {}\n", printable(doubt));
  };
  std::string text;
  if (findings.failed) text += findings.verdict + "\n";
  for (std::size_t at = 0; at < findings.spoiling; ++at) text += line_of(findings.doubts[at]);
  if (!text.empty()) text += "\n";
  text += aligned(rows);
  text += fmt::format(
      "\nratio: seconds over those of the floor, the same bytes moved by a plain "
      "program; {} runs\n",
      set.runs.size());
  if (!findings.failed) text += printable(findings.verdict) + "\n";
  if (findings.spoiling < findings.doubts.size()) text += "doubts:\n";
  for (std::size_t at = findings.spoiling; at < findings.doubts.size(); ++at)
    text += line_of(findings.doubts[at]);
  return text;
}

}  // namespace plait::bench
