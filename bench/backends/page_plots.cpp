#include <fmt/format.h>

#include "backends/page_parts.h"

namespace plait::bench {

using instrument::IntervalPlot;
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
            plot.points.push_back({place_of(figures.cell), figures.name, "", figures.ratio->value,
                                   figures.ratio->low, figures.ratio->high,
                                   fmt::format("{} rounds, {}; {:.3g} s", figures.ratio->count,
                                               figures.label, figures.seconds->value),
                                   figures.label == "warm" || figures.label == "memory"});
          }
        parts.page.plot(plot);
      });
}

}  // namespace plait::bench
