#include <fmt/format.h>

#include "bench/page_parts.h"

namespace plait::bench {

using instrument::LinePlot;
using instrument::Scale;

namespace {

/// Curves of as many contests are drawn, so that the page of a large set stays readable.
constexpr std::size_t kMostCurves = 40;

/// The curves of each contest that has some, and a line about those that are left out.
template <class Add>
void write_curves(const PageParts& parts, const LinePlot& empty, const std::string& nothing,
                  Add add) {
  std::size_t drawn = 0;
  std::size_t left_out = 0;
  for (const Contest& contest : parts.findings.contests) {
    LinePlot plot = empty;
    const MeasuredCell& cell = parts.first_of(contest).cell;
    plot.caption.title = work_of(cell) + ", " + place_of(cell);
    for (const std::size_t at : contest.cells)
      if (parts.findings.cells[at].seconds)
        add(parts.findings.cells[at], parts.set.runs[parts.findings.cells[at].middle], plot);
    if (plot.lines.empty()) continue;
    if (drawn == kMostCurves) {
      ++left_out;
      continue;
    }
    ++drawn;
    parts.page.plot(plot);
  }
  if (drawn == 0) parts.page.paragraph(nothing);
  if (left_out > 0)
    parts.page.paragraph(
        fmt::format("{} more comparisons have such curves, and are left out here.", left_out));
}

}  // namespace

void write_latencies(const PageParts& parts) {
  LinePlot plot;
  plot.caption = parts.caption("",
                               "Lower is better. At 99 % stands the latency that one request in a "
                               "hundred exceeds; each further nine has the same room. The run of "
                               "the median time.");
  plot.x = {"share of requests that were at least as fast", "%", Scale::kNines};
  plot.y = {"latency", "s", Scale::kLog};
  write_curves(parts, plot, "No run measured latencies.",
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

void write_throughput(const PageParts& parts) {
  LinePlot plot;
  plot.caption = parts.caption("",
                               "A level line is a steady disk; a step down is a cache that was "
                               "full, a sawtooth is write-back. The run of the median time.");
  plot.x = {"time", "s"};
  plot.y = {"raw bytes a second", "B/s", Scale::kLinear, true};
  write_curves(
      parts, plot, "No run recorded its throughput over time.",
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

}  // namespace plait::bench
