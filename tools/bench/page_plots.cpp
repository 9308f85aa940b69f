#include <fmt/format.h>

#include "bench/page_parts.h"

namespace plait::bench {

using instrument::BarPlot;
using instrument::IntervalPlot;
using instrument::kMissing;
using instrument::Scale;

void write_ratios(const PageParts& parts) {
  parts.for_each_workload(
      [&](const std::string& work, const std::vector<const Contest*>& contests) {
        IntervalPlot plot;
        plot.caption =
            parts.caption(work,
                          "Left is better: 1 is the floor, a plain program that moves the same "
                          "bytes in the same round. Lines are 95 % intervals of the median; "
                          "outlines are warm or memory, and no figures of a disk.");
        plot.x = {"seconds, in those of the floor", "x", Scale::kLog};
        plot.reference = 1;
        for (const Contest* contest : contests)
          for (const std::size_t at : contest->cells) {
            const CellFigures& figures = parts.findings.cells[at];
            if (!figures.ratio) continue;
            plot.points.push_back({figures.cell.disk, figures.name, size_of(figures.cell),
                                   figures.ratio->value, figures.ratio->low, figures.ratio->high,
                                   fmt::format("{} rounds, {}; {:.3g} s", figures.ratio->count,
                                               figures.label, figures.seconds->value),
                                   figures.label == "warm" || figures.label == "memory"});
          }
        parts.page.plot(plot);
      });
}

void write_splits(const PageParts& parts) {
  parts.for_each_workload(
      [&](const std::string& work, const std::vector<const Contest*>& contests) {
        BarPlot plot;
        plot.caption = parts.caption(
            work,
            "The run of the median time. Wait and codec are summed over threads, and a caller "
            "may wait for the codec, so a bar may be longer than the run.");
        plot.x = {"seconds", "s"};
        plot.parts = {"compute", "wait", "codec", "sync"};
        for (const Contest* contest : contests)
          for (const std::size_t at : contest->cells) {
            const CellFigures& figures = parts.findings.cells[at];
            if (!figures.seconds) continue;
            const MeasuredRun& run = parts.set.runs[figures.middle];
            if (!run.compute && !run.wait && !run.sync) continue;
            plot.bars.push_back({place_of(figures.cell),
                                 figures.name,
                                 {run.compute.value_or(kMissing), run.wait.value_or(kMissing),
                                  run.codec.value_or(kMissing), run.sync.value_or(kMissing)},
                                 fmt::format("{:.3g} s in all", run.seconds)});
          }
        parts.page.plot(plot);
      });
}

void write_bytes(const PageParts& parts) {
  parts.for_each_workload(
      [&](const std::string& work, const std::vector<const Contest*>& contests) {
        IntervalPlot plot;
        plot.caption =
            parts.caption(work,
                          "Bytes that were moved for each byte that the work needed: 1 is no "
                          "waste, under 1 is what the cache or compression saved.");
        plot.x = {"bytes moved for each byte needed", "x", Scale::kLog};
        plot.reference = 1;
        for (const Contest* contest : contests)
          for (const std::size_t at : contest->cells) {
            const CellFigures& figures = parts.findings.cells[at];
            if (!figures.seconds) continue;
            const MeasuredRun& run = parts.set.runs[figures.middle];
            const auto add = [&](const char* series, const std::optional<double>& needed,
                                 const std::optional<double>& moved) {
              if (!needed || !moved || *needed <= 0 || *moved <= 0) return;
              const double factor = *moved / *needed;
              plot.points.push_back(
                  {place_of(figures.cell), figures.name, series, factor, kMissing, kMissing,
                   fmt::format("{} for {}", bytes_cell(moved).text, bytes_cell(needed).text)});
            };
            add("read by the pager", run.needed_read, run.moved_read);
            add("written by the pager", run.needed_written, run.moved_written);
            add("read by the device", run.needed_read, run.device_read);
            add("written by the device", run.needed_written, run.device_written);
          }
        parts.page.plot(plot);
      });
}

}  // namespace plait::bench
