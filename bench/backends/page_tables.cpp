#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "backends/first_screen.h"
#include "backends/page_parts.h"

namespace plait::bench {

using instrument::Cell;
using instrument::kMissing;
using instrument::Table;
using instrument::Tone;

Cell figure_cell(const std::optional<double>& value, const char* unit) {
  return value ? Cell(fmt::format("{:.3g}{}", *value, unit), *value) : Cell("–", kMissing);
}

std::string place_of(const MeasuredCell& cell) {
  std::string place = cell.disk;
  if (const std::string size = size_of(cell); !size.empty()) place += ", " + size;
  return place;
}

void write_matrix(const PageParts& parts) {
  Table table;
  table.caption = parts.caption("Which backend for which work",
                                "Compared in pairs by round, on the logarithm of seconds, with "
                                "intervals that are corrected for "
                                "how many comparisons there are. Never: twice the time of the "
                                "fastest or more, or runs that died.");
  table.columns = {{"disk", false},    {"workload", false}, {"size", false},
                   {"fastest", false}, {"others", false},   {"never", false}};
  for (const MatrixRow& row : matrix_of(parts.findings))
    table.rows.push_back({{row.disk, row.work, row.size, row.fastest, row.others, row.never},
                          parts.findings.failed ? Tone::kFailed : Tone::kPlain});
  if (!table.rows.empty()) parts.page.table(table);
  parts.page.list(advice_of(parts.findings), Tone::kPlain);
}

void write_splits(const PageParts& parts) {
  Table table;
  table.caption = parts.caption("Where time and bytes go",
                                "The run of the median time. Wait and codec are summed over "
                                "threads, and a caller may wait for "
                                "the codec. Bytes for each byte that the work needed: over 1 is "
                                "waste, under 1 is what a cache or "
                                "compression saved.");
  table.columns = {
      {"disk", false},  {"workload", false}, {"backend", false}, {"seconds"},     {"compute"},
      {"wait"},         {"codec"},           {"sync"},           {"pager reads"}, {"pager writes"},
      {"device reads"}, {"device writes"}};
  for (const Contest& contest : parts.findings.contests)
    for (const std::size_t at : contest.cells) {
      const CellFigures& figures = parts.findings.cells[at];
      if (!figures.seconds) continue;
      const MeasuredRun& run = parts.set.runs[figures.middle];
      const auto factor = [](const std::optional<double>& moved,
                             const std::optional<double>& needed) {
        return moved && needed && *needed > 0 ? figure_cell(*moved / *needed, " ×")
                                              : Cell("–", kMissing);
      };
      table.rows.push_back(
          {{place_of(figures.cell), work_of(figures.cell), figures.name, figure_cell(run.seconds),
            figure_cell(run.compute), figure_cell(run.wait), figure_cell(run.codec),
            figure_cell(run.sync), factor(run.moved_read, run.needed_read),
            factor(run.moved_written, run.needed_written), factor(run.device_read, run.needed_read),
            factor(run.device_written, run.needed_written)}});
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

void write_latencies(const PageParts& parts) {
  Table table;
  table.caption = parts.caption("How long requests took",
                                "Milliseconds, in the run of the median time: half of the requests "
                                "took at most p50, all but one in a hundred p99.");
  table.columns = {{"disk", false}, {"workload", false}, {"backend", false}, {"p50"}, {"p90"},
                   {"p99"},         {"p99.9"},           {"longest"}};
  const auto milliseconds = [](const std::optional<double>& seconds) {
    return figure_cell(seconds ? std::optional(*seconds * 1e3) : std::nullopt);
  };
  for (const Contest& contest : parts.findings.contests)
    for (const std::size_t at : contest.cells) {
      const CellFigures& figures = parts.findings.cells[at];
      if (!figures.seconds || !parts.set.runs[figures.middle].p50) continue;
      const MeasuredRun& run = parts.set.runs[figures.middle];
      table.rows.push_back({{place_of(figures.cell), work_of(figures.cell), figures.name,
                             milliseconds(run.p50), milliseconds(run.p90), milliseconds(run.p99),
                             milliseconds(run.p999), milliseconds(run.longest)}});
    }
  if (table.rows.empty())
    parts.page.paragraph("No run measured latencies.");
  else
    parts.page.table(table);
}

}  // namespace plait::bench
