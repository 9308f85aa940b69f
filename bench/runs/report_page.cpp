#include "runs/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "instrument/figure_text.h"

namespace plait::bench {
namespace {

using instrument::IntervalPlot;
using instrument::Page;
using instrument::seconds_text;
using instrument::Table;
using instrument::table_with;
using instrument::Tone;

/// Fewer are no plot.
constexpr std::size_t kLeastPoints = 20;

/// A figure that is missing is a dash.
std::string seconds_cell(const std::optional<double>& value) {
  return value ? seconds_text(*value) : "–";
}
std::string factor_cell(const std::optional<double>& moved, const std::optional<double>& needed) {
  return moved && needed && *needed > 0 ? fmt::format("{:.3g} ×", *moved / *needed) : "–";
}

/// The disk, and the size if there is one.
std::string place_of(const MeasuredCell& cell) {
  const std::string size = size_of(cell);
  return cell.disk + (size.empty() ? "" : ", " + size);
}

/// Calls `add` for each cell, contest by contest.
template <class Add>
void for_each_cell(const Findings& findings, Add add) {
  for (const Contest& contest : findings.contests)
    for (const std::size_t at : contest.cells) add(findings.cells[at]);
}

std::string subtitle(const RunSet& set, const Findings& findings) {
  std::set<std::string> started;
  for (const MeasuredRun& run : set.runs)
    if (!run.started.empty()) started.insert(run.started);
  std::string text = fmt::format("{} runs of {} cells", set.runs.size(), findings.cells.size());
  for (const char* name : {"processor", "kernel", "plait"})
    if (const std::string value = set.runs.front().environment_at(name); !value.empty())
      text += " · " + value;
  if (!started.empty()) text += " · " + *started.begin();
  if (started.size() > 1) text += " to " + *started.rbegin();
  return text;
}

/// Ratios to the floor, a plot for each workload with enough points.
void add_ratios(Page& page, const Findings& findings, const std::string& command) {
  std::map<std::string, IntervalPlot> plots;
  for_each_cell(findings, [&](const CellFigures& figures) {
    if (figures.ratio)
      plots[figures.cell.workload].points.push_back(
          {place_of(figures.cell), figures.name, figures.ratio->value, figures.ratio->low,
           figures.ratio->high,
           fmt::format("{} rounds, {}; {}", figures.ratio->count, figures.label,
                       seconds_text(figures.seconds->value)),
           figures.label == "warm" || figures.label == "memory"});
  });
  std::erase_if(plots, [](const auto& each) { return each.second.points.size() < kLeastPoints; });
  if (!plots.empty()) page.add(instrument::Section{"Ratio to the floor"});
  for (auto& [work, plot] : plots) {
    plot.caption = {work,
                    "Left is better: 1 is the floor, a plain program that moves the same bytes in "
                    "the same round. Lines are 95 % intervals; outlines are warm or memory, and no "
                    "figures of a disk.",
                    command};
    plot.x = {"seconds, in those of the floor", "×"};
    plot.reference = 1;
    page.add(std::move(plot));
  }
}

Table splits_table(const RunSet& set, const Findings& findings, const std::string& command) {
  Table table = table_with(
      "disk|workload|backend|#seconds|#compute|#wait|#codec|#sync|#pager reads|#pager "
      "writes|#device reads|#device writes",
      {"Where time and bytes go",
       "The run of the median time. Wait and codec are summed over threads, and a caller "
       "may wait for the codec. Bytes for each byte that the work needed: over 1 is waste, "
       "under 1 is what a cache or compression saved.",
       command});
  for_each_cell(findings, [&](const CellFigures& figures) {
    if (!figures.seconds) return;
    const MeasuredRun& run = set.runs[figures.middle];
    table.rows.push_back(
        {{place_of(figures.cell), figures.cell.workload, figures.name, seconds_cell(run.seconds),
          seconds_cell(run.compute), seconds_cell(run.wait), seconds_cell(run.codec),
          seconds_cell(run.sync), factor_cell(run.moved_read, run.needed_read),
          factor_cell(run.moved_written, run.needed_written),
          factor_cell(run.device_read, run.needed_read),
          factor_cell(run.device_written, run.needed_written)}});
  });
  return table;
}

/// A column for each environment that differs in anything but the free space.
Table environments_table(const RunSet& set) {
  constexpr std::size_t kMost = 12;
  std::vector<std::map<std::string, std::string>> environments;
  std::set<std::string> names;
  for (const MeasuredRun& run : set.runs) {
    std::map<std::string, std::string> environment = run.environment;
    environment.erase("disk.free_bytes");
    if (environments.size() == kMost || std::ranges::count(environments, environment) > 0) continue;
    for (const auto& [name, value] : environment) names.insert(name);
    environments.push_back(std::move(environment));
  }
  Table table = table_with(
      "", {"What the runs ran on", "A column for each disk or machine, at most twelve."});
  for (std::size_t at = 0; at < environments.size(); ++at)
    table.columns.push_back({fmt::format("{}", at + 1), false});
  for (const std::string& name : names) {
    Table::Row& row = table.rows.emplace_back(Table::Row{{name}});
    for (auto& environment : environments)
      row.cells.emplace_back(environment.contains(name) ? environment[name] : "–");
  }
  return table;
}

/// The figures of each cell; how long requests took is of the run of the median time.
Table figures_table(const RunSet& set, const Findings& findings) {
  Table table = table_with(
      "#ratio|#95 %|#seconds|#MB/s|#p50|#p99|#p99.9|#rounds|backend|workload|size|disk|state");
  for_each_cell(findings, [&](const CellFigures& figures) {
    static const MeasuredRun kNone;
    const MeasuredRun& run = figures.seconds ? set.runs[figures.middle] : kNone;
    const double needed = run.needed_read.value_or(0) + run.needed_written.value_or(0);
    std::string state = figures.label;  // a write is neither cold nor warm
    if (const std::string survival = survival_of(figures); !survival.empty())
      state += (state.empty() ? "" : ", ") + survival;
    const auto& ratio = figures.ratio;
    table.rows.push_back(
        {{ratio ? fmt::format("{:.2f}", ratio->value) : "–",
          ratio ? fmt::format("{:.2f}-{:.2f}", ratio->low, ratio->high) : "–",
          figures.seconds ? seconds_text(figures.seconds->value) : "–",
          needed > 0 ? fmt::format("{:.0f}", 1e-6 * needed / run.seconds) : "–",
          seconds_cell(run.p50), seconds_cell(run.p99), seconds_cell(run.p999),
          fmt::format("{}", figures.runs.size()), figures.name, figures.cell.workload,
          size_of(figures.cell), figures.cell.disk, state}});
  });
  return table;
}

/// What a reader needs first, on a terminal and on a page: the verdict, the doubts that spoil
/// everything, the matrix with the advice, and the other doubts.
void add_first_screen(Page& page, const Findings& findings) {
  const Tone tone_of_doubts = findings.failed ? Tone::kFailed : Tone::kDoubt;
  page.add(instrument::Verdict{findings.verdict,
                               findings.doubts.empty() ? Tone::kGood : tone_of_doubts});
  const auto others = findings.doubts.begin() + static_cast<std::ptrdiff_t>(findings.spoiling);
  if (findings.spoiling > 0)
    page.add(instrument::List{{findings.doubts.begin(), others}, tone_of_doubts});
  if (Table matrix = matrix_table(findings); !matrix.rows.empty()) page.add(std::move(matrix));
  page.add(instrument::List{advice_of(findings), Tone::kPlain});
  if (others == findings.doubts.end()) return;
  page.add(instrument::Section{"Doubts"});
  page.add(instrument::List{{others, findings.doubts.end()}, tone_of_doubts});
}

}  // namespace

std::string to_text(const RunSet& set, const Findings& findings) {
  /// More cells than a screen has lines are on the page and in the JSON only.
  constexpr std::size_t kMostCells = 40;
  Page page;
  add_first_screen(page, findings);
  if (findings.cells.size() <= kMostCells) {
    page.add(figures_table(set, findings));
    page.add(instrument::Paragraph{
        fmt::format("ratio: seconds over those of the floor, the same bytes moved by a plain "
                    "program; {} runs",
                    set.runs.size())});
  } else {
    page.add(instrument::Paragraph{fmt::format(
        "the figures of {} cells are on the page (--html) and in --json", findings.cells.size())});
  }
  return to_text(page);
}

std::string to_page(const RunSet& set, const Findings& findings, const std::string& command) {
  Page page{"plait bench", subtitle(set, findings)};
  add_first_screen(page, findings);
  add_ratios(page, findings, command);
  const std::pair<const char*, Table> tables[] = {
      {"Figures", figures_table(set, findings)},
      {"Time and bytes", splits_table(set, findings, command)},
      {"Environment", environments_table(set)}};
  for (const auto& [heading, table] : tables) {
    if (table.rows.empty()) continue;
    page.add(instrument::Section{heading});
    page.add(table);
  }
  return to_html(page);
}

}  // namespace plait::bench
