#include "bench/findings_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "instrument/html_page.h"
#include "plait/byte_text.h"

namespace plait::bench {
namespace {

using instrument::Axis;
using instrument::BarPlot;
using instrument::Caption;
using instrument::Cell;
using instrument::HtmlPage;
using instrument::IntervalPlot;
using instrument::kMissing;
using instrument::LinePlot;
using instrument::Scale;
using instrument::Table;
using instrument::Tone;

/// Curves of as many contests are drawn, so that the page of a large set stays readable.
constexpr std::size_t kMostCurves = 40;

std::string figure_text(double value, const char* unit) {
  return fmt::format("{:.3g}{}", value, unit);
}

Cell figure(const std::optional<double>& value, const char* unit = "") {
  return value ? Cell(figure_text(*value, unit), *value) : Cell("–", kMissing);
}

Cell bytes(const std::optional<double>& value) {
  if (!value || *value > 1e18) return Cell("–", kMissing);
  return Cell(format_bytes(static_cast<std::uint64_t>(*value)), *value);
}

class PageOfFindings {
 public:
  PageOfFindings(const RunSet& set, const Findings& findings, const std::string& command)
      : set_(set), findings_(findings), command_(command), page_("plait bench", subtitle()) {}

  std::string write() {
    page_.verdict(findings_.verdict, findings_.failed     ? Tone::kFailed
                                     : findings_.doubtful ? Tone::kDoubt
                                                          : Tone::kGood);
    if (findings_.doubtful) {
      page_.section("Doubts");
      page_.list(findings_.doubts, findings_.failed ? Tone::kFailed : Tone::kDoubt);
    }
    page_.section("Comparisons");
    write_contests();
    page_.section("Ratio to the floor");
    write_ratios();
    page_.section("Where the time goes");
    write_splits();
    page_.section("Bytes");
    write_bytes();
    page_.section("Latency");
    write_latencies();
    page_.section("Throughput over time");
    write_throughput();
    page_.section("Environment");
    write_environment();
    page_.section("Every run");
    write_runs();
    page_.embed("report", to_json(set_, findings_));
    return page_.html();
  }

 private:
  std::string subtitle() const {
    std::string first;
    std::string last;
    for (const MeasuredRun& run : set_.runs) {
      if (run.started.empty()) continue;
      if (first.empty() || run.started < first) first = run.started;
      last = std::max(last, run.started);
    }
    std::string text = fmt::format("{} runs of {} cells", set_.runs.size(), findings_.cells.size());
    const auto add = [&](const char* name) {
      const auto& environment = set_.runs.front().environment;
      if (const auto found = environment.find(name); found != environment.end())
        text += " · " + found->second;
    };
    add("processor");
    add("kernel");
    add("plait");
    if (!first.empty()) text += " · " + first + (first == last ? "" : " to " + last);
    return text;
  }

  Caption caption(std::string title, std::string how_to_read) const {
    return {std::move(title), std::move(how_to_read), command_};
  }

  static std::string place_of(const MeasuredCell& cell) {
    std::string place = cell.disk;
    if (const std::string size = size_of(cell); !size.empty()) place += ", " + size;
    return place;
  }

  const CellFigures& first_of(const Contest& contest) const {
    return findings_.cells[contest.cells.front()];
  }

  /// Calls `write` for each workload with its contests, in the order of their names.
  template <class Write>
  void for_each_workload(Write write) const {
    std::map<std::string, std::vector<const Contest*>> workloads;
    for (const Contest& contest : findings_.contests)
      workloads[work_of(first_of(contest).cell)].push_back(&contest);
    for (const auto& [work, contests] : workloads) write(work, contests);
  }

  void write_contests() {
    Table table;
    table.caption =
        caption("The fastest of each comparison",
                "A cell is the fastest only where its 95 % interval of seconds overlaps "
                "with no other's. Everything else is undecided.");
    table.columns = {{"disk", false},    {"workload", false},      {"size", false},
                     {"fastest", false}, {"lead over the second"}, {"why not decided", false}};
    for (const Contest& contest : findings_.contests) {
      const CellFigures& first = first_of(contest);
      table.rows.push_back(
          {{first.cell.disk, work_of(first.cell),
            Cell(size_of(first.cell), first.cell.ratio.value_or(first.cell.vertices.value_or(0))),
            contest.decided ? first.name : "undecided",
            contest.ranked > 1 ? Cell(fmt::format("{:.2f} ×", contest.lead), contest.lead)
                               : Cell("–", kMissing),
            contest.why_not},
           findings_.failed ? Tone::kFailed : Tone::kPlain});
    }
    page_.table(table);
  }

  void write_ratios() {
    for_each_workload([&](const std::string& work, const std::vector<const Contest*>& contests) {
      IntervalPlot plot;
      plot.caption = caption(work,
                             "Left is better: 1 is the floor, a plain program that moves the same "
                             "bytes in the same round. Lines are 95 % intervals of the median; "
                             "outlines are warm or memory, and no figures of a disk.");
      plot.x = {"seconds, in those of the floor", "x", Scale::kLog};
      plot.reference = 1;
      for (const Contest* contest : contests)
        for (const std::size_t at : contest->cells) {
          const CellFigures& figures = findings_.cells[at];
          if (!figures.ratio) continue;
          plot.points.push_back({figures.cell.disk, figures.name, size_of(figures.cell),
                                 figures.ratio->value, figures.ratio->low, figures.ratio->high,
                                 fmt::format("{} rounds, {}; {:.3g} s", figures.ratio->count,
                                             figures.label, figures.seconds->value),
                                 figures.label == "warm" || figures.label == "memory"});
        }
      page_.plot(plot);
    });
  }

  void write_splits() {
    for_each_workload([&](const std::string& work, const std::vector<const Contest*>& contests) {
      BarPlot plot;
      plot.caption =
          caption(work,
                  "The run of the median time. Wait is summed over threads, so a bar may "
                  "be longer than the run; codec is shown where it was measured.");
      plot.x = {"seconds", "s"};
      plot.parts = {"compute", "wait", "codec", "sync"};
      for (const Contest* contest : contests)
        for (const std::size_t at : contest->cells) {
          const CellFigures& figures = findings_.cells[at];
          if (!figures.seconds) continue;
          const MeasuredRun& run = set_.runs[figures.middle];
          if (!run.compute && !run.wait && !run.sync) continue;
          plot.bars.push_back({place_of(figures.cell),
                               figures.name,
                               {run.compute.value_or(kMissing), run.wait.value_or(kMissing),
                                run.codec.value_or(kMissing), run.sync.value_or(kMissing)},
                               fmt::format("{:.3g} s in all", run.seconds)});
        }
      page_.plot(plot);
    });
  }

  void write_bytes() {
    for_each_workload([&](const std::string& work, const std::vector<const Contest*>& contests) {
      IntervalPlot plot;
      plot.caption = caption(work,
                             "Bytes that were moved for each byte that the work needed: 1 is no "
                             "waste, under 1 is what the cache or compression saved.");
      plot.x = {"bytes moved for each byte needed", "x", Scale::kLog};
      plot.reference = 1;
      for (const Contest* contest : contests)
        for (const std::size_t at : contest->cells) {
          const CellFigures& figures = findings_.cells[at];
          if (!figures.seconds) continue;
          const MeasuredRun& run = set_.runs[figures.middle];
          const auto add = [&](const char* series, const std::optional<double>& needed,
                               const std::optional<double>& moved) {
            if (!needed || !moved || *needed <= 0 || *moved <= 0) return;
            const double factor = *moved / *needed;
            plot.points.push_back(
                {place_of(figures.cell), figures.name, series, factor, kMissing, kMissing,
                 fmt::format("{} for {}", bytes(moved).text, bytes(needed).text)});
          };
          add("read by the pager", run.needed_read, run.moved_read);
          add("written by the pager", run.needed_written, run.moved_written);
          add("read by the device", run.needed_read, run.device_read);
          add("written by the device", run.needed_written, run.device_written);
        }
      page_.plot(plot);
    });
  }

  /// The curves of each contest that has some, and a line about those that are left out.
  template <class Add>
  void write_curves(const LinePlot& empty, const std::string& nothing, Add add) {
    std::size_t drawn = 0;
    std::size_t left_out = 0;
    for (const Contest& contest : findings_.contests) {
      LinePlot plot = empty;
      const MeasuredCell& cell = first_of(contest).cell;
      plot.caption.title = work_of(cell) + ", " + place_of(cell);
      for (const std::size_t at : contest.cells)
        if (findings_.cells[at].seconds)
          add(findings_.cells[at], set_.runs[findings_.cells[at].middle], plot);
      if (plot.lines.empty()) continue;
      if (drawn == kMostCurves) {
        ++left_out;
        continue;
      }
      ++drawn;
      page_.plot(plot);
    }
    if (drawn == 0) page_.paragraph(nothing);
    if (left_out > 0)
      page_.paragraph(
          fmt::format("{} more comparisons have such curves, and are left out here.", left_out));
  }

  void write_latencies() {
    LinePlot plot;
    plot.caption = caption("",
                           "Lower is better. At 99 % stands the latency that one request in a "
                           "hundred exceeds; each further nine has the same room. The run of "
                           "the median time.");
    plot.x = {"share of requests that were at least as fast", "%", Scale::kNines};
    plot.y = {"latency", "s", Scale::kLog};
    write_curves(
        plot, "No run measured latencies.",
        [](const CellFigures& figures, const MeasuredRun& run, LinePlot& into) {
          double all = 0;
          for (const double count : run.latency_counts) all += count;
          if (all <= 0) return;
          LinePlot::Line line{figures.name};
          double sum = 0;
          for (std::size_t at = 0; at < run.latency_counts.size(); ++at) {
            if (run.latency_counts[at] <= 0) continue;
            sum += run.latency_counts[at];
            // All requests of the last bin are at most the longest one.
            const bool last = sum >= all;
            line.x.push_back(last ? 1 - 0.5 / all : sum / all);
            line.y.push_back(last && run.longest ? *run.longest : run.latency_edges[at + 1]);
          }
          if (run.p99) line.note = fmt::format("p99 {:.3g} ms", *run.p99 * 1e3);
          into.lines.push_back(std::move(line));
        });
  }

  void write_throughput() {
    LinePlot plot;
    plot.caption = caption("",
                           "A level line is a steady disk; a step down is a cache that was "
                           "full, a sawtooth is write-back. The run of the median time.");
    plot.x = {"time", "s"};
    plot.y = {"raw bytes a second", "B/s", Scale::kLinear, true};
    write_curves(
        plot, "No run recorded its throughput over time.",
        [](const CellFigures& figures, const MeasuredRun& run, LinePlot& into) {
          LinePlot::Line line{figures.name};
          for (std::size_t at = 1; at < run.throughput_seconds.size(); ++at) {
            const double time = run.throughput_seconds[at] - run.throughput_seconds[at - 1];
            const double moved = run.throughput_bytes[at] - run.throughput_bytes[at - 1];
            if (time <= 0 || moved < 0) continue;
            line.x.push_back((run.throughput_seconds[at] + run.throughput_seconds[at - 1]) / 2);
            line.y.push_back(moved / time);
          }
          if (!line.x.empty()) into.lines.push_back(std::move(line));
        });
  }

  void write_environment() {
    // A column for each environment that differs in anything but the free space.
    std::vector<std::map<std::string, std::string>> environments;
    std::set<std::string> names;
    for (const MeasuredRun& run : set_.runs) {
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
      page_.paragraph("The records say nothing of their environment.");
    else
      page_.table(table);
  }

  void write_runs() {
    std::map<std::string, const CellFigures*> cell_of_key;
    for (const CellFigures& figures : findings_.cells)
      for (const std::size_t at : figures.runs) cell_of_key[set_.runs[at].key] = &figures;
    Table table;
    table.caption = caption("Every run", "A heading sorts. Warm and failed runs are coloured.");
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
      return figure(seconds ? std::optional(*seconds * 1e3) : std::nullopt);
    };
    for (const MeasuredRun& run : set_.runs) {
      const auto found = cell_of_key.find(run.key);
      const std::string state = run.ok ? run.label : "failed: " + run.failure;
      table.rows.push_back(
          {{run.cell.disk,
            work_of(run.cell),
            Cell(size_of(run.cell), run.cell.ratio.value_or(run.cell.vertices.value_or(0))),
            found == cell_of_key.end() ? run.cell.backend : found->second->name,
            Cell(fmt::format("{}", run.round), static_cast<double>(run.round)),
            figure(run.ratio),
            run.ok ? figure(run.seconds) : Cell("–", kMissing),
            figure(run.floor_seconds),
            figure(run.fio_seconds),
            state,
            bytes(sum(run.needed_read, run.needed_written)),
            bytes(sum(run.moved_read, run.moved_written)),
            bytes(sum(run.device_read, run.device_written)),
            bytes(run.stored),
            milliseconds(run.p50),
            milliseconds(run.p99),
            bytes(run.peak_rss),
            figure(run.user_seconds),
            figure(run.system_seconds),
            figure(run.major_faults),
            fmt::format("{}:{}", run.file, run.line)},
           !run.ok               ? Tone::kFailed
           : run.label == "warm" ? Tone::kDoubt
                                 : Tone::kPlain});
    }
    page_.table(table);
  }

  const RunSet& set_;
  const Findings& findings_;
  const std::string& command_;
  HtmlPage page_;
};

}  // namespace

std::string to_page(const RunSet& set, const Findings& findings, const std::string& command) {
  return PageOfFindings(set, findings, command).write();
}

}  // namespace plait::bench
