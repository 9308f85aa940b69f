#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "bench/page_parts.h"
#include "plait/byte_text.h"

namespace plait::bench {

using instrument::Cell;
using instrument::kMissing;
using instrument::Table;
using instrument::Tone;

Cell figure_cell(const std::optional<double>& value, const char* unit) {
  return value ? Cell(fmt::format("{:.3g}{}", *value, unit), *value) : Cell("–", kMissing);
}

Cell bytes_cell(const std::optional<double>& value) {
  if (!value || *value > 1e18) return Cell("–", kMissing);
  return Cell(format_bytes(static_cast<std::uint64_t>(*value)), *value);
}

std::string place_of(const MeasuredCell& cell) {
  std::string place = cell.disk;
  if (const std::string size = size_of(cell); !size.empty()) place += ", " + size;
  return place;
}

void write_contests(const PageParts& parts) {
  Table table;
  table.caption =
      parts.caption("The fastest of each comparison",
                    "A cell is the fastest only where its 95 % interval of seconds overlaps "
                    "with no other's. Everything else is undecided.");
  table.columns = {{"disk", false},    {"workload", false},      {"size", false},
                   {"fastest", false}, {"lead over the second"}, {"why not decided", false}};
  for (const Contest& contest : parts.findings.contests) {
    const CellFigures& first = parts.first_of(contest);
    table.rows.push_back(
        {{first.cell.disk, work_of(first.cell),
          Cell(size_of(first.cell), first.cell.ratio.value_or(first.cell.vertices.value_or(0))),
          contest.decided ? first.name : "undecided",
          contest.ranked > 1 ? Cell(fmt::format("{:.2f} ×", contest.lead), contest.lead)
                             : Cell("–", kMissing),
          contest.why_not},
         parts.findings.failed ? Tone::kFailed : Tone::kPlain});
  }
  parts.page.table(table);
}

void write_environment(const PageParts& parts) {
  // A column for each environment that differs in anything but the free space.
  std::vector<std::map<std::string, std::string>> environments;
  std::set<std::string> names;
  for (const MeasuredRun& run : parts.set.runs) {
    std::map<std::string, std::string> environment = run.environment;
    environment.erase("disk.free_bytes");
    if (environments.size() < 12 &&
        std::find(environments.begin(), environments.end(), environment) == environments.end()) {
      for (const auto& [name, value] : environment) names.insert(name);
      environments.push_back(std::move(environment));
    }
  }
  Table table;
  table.caption = {"What the runs ran on", "A column for each disk or machine, at most twelve."};
  table.columns = {{"", false}};
  for (std::size_t at = 0; at < environments.size(); ++at)
    table.columns.push_back({fmt::format("{}", at + 1), false});
  for (const std::string& name : names) {
    Table::Row row{{name}};
    for (const auto& environment : environments) {
      const auto found = environment.find(name);
      row.cells.push_back(found == environment.end() ? Cell("–") : Cell(found->second));
    }
    table.rows.push_back(std::move(row));
  }
  if (names.empty())
    parts.page.paragraph("The records say nothing of their environment.");
  else
    parts.page.table(table);
}

void write_runs(const PageParts& parts) {
  std::map<std::string, const CellFigures*> cell_of_key;
  for (const CellFigures& figures : parts.findings.cells)
    for (const std::size_t at : figures.runs) cell_of_key[parts.set.runs[at].key] = &figures;
  Table table;
  table.caption = parts.caption("Every run", "A heading sorts. Warm and failed runs are coloured.");
  table.columns = {{"disk", false},   {"workload", false}, {"size"},      {"backend", false},
                   {"round"},         {"ratio"},           {"seconds"},   {"floor, s"},
                   {"fio, s"},        {"state", false},    {"needed"},    {"moved"},
                   {"on the device"}, {"stored"},          {"p50, ms"},   {"p99, ms"},
                   {"peak memory"},   {"user, s"},         {"system, s"}, {"major faults"},
                   {"where", false}};
  const auto sum = [](const std::optional<double>& a, const std::optional<double>& b) {
    return a || b ? std::optional(a.value_or(0) + b.value_or(0)) : std::nullopt;
  };
  const auto milliseconds = [](const std::optional<double>& seconds) {
    return figure_cell(seconds ? std::optional(*seconds * 1e3) : std::nullopt);
  };
  for (const MeasuredRun& run : parts.set.runs) {
    const auto found = cell_of_key.find(run.key);
    const std::string state = run.ok ? run.label : "failed: " + run.failure;
    table.rows.push_back(
        {{run.cell.disk,
          work_of(run.cell),
          Cell(size_of(run.cell), run.cell.ratio.value_or(run.cell.vertices.value_or(0))),
          found == cell_of_key.end() ? run.cell.backend : found->second->name,
          Cell(fmt::format("{}", run.round), static_cast<double>(run.round)),
          figure_cell(run.ratio),
          run.ok ? figure_cell(run.seconds) : Cell("–", kMissing),
          figure_cell(run.floor_seconds),
          figure_cell(run.fio_seconds),
          state,
          bytes_cell(sum(run.needed_read, run.needed_written)),
          bytes_cell(sum(run.moved_read, run.moved_written)),
          bytes_cell(sum(run.device_read, run.device_written)),
          bytes_cell(run.stored),
          milliseconds(run.p50),
          milliseconds(run.p99),
          bytes_cell(run.peak_rss),
          figure_cell(run.user_seconds),
          figure_cell(run.system_seconds),
          figure_cell(run.major_faults),
          fmt::format("{}:{}", run.file, run.line)},
         !run.ok               ? Tone::kFailed
         : run.label == "warm" ? Tone::kDoubt
                               : Tone::kPlain});
  }
  parts.page.table(table);
}

}  // namespace plait::bench
