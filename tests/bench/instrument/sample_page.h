// A page with every kind of plot, for tests.
#pragma once

#include "instrument/page.h"

namespace plait::test {

/// Text that would break out of HTML, of a script, or of an attribute.
inline const std::string kHostileText =
    "</script><script>document.body.dataset.broken=1</script><!-- \"'><img src=x onerror=alert(1)>";

inline instrument::Page sample_page() {
  using namespace instrument;
  Page page{"A page of every kind", "five rounds on a made-up machine"};
  page.add(Verdict{"uring is the fastest on ext4 (1.04 times the floor); on tmpfs it is undecided.",
                   Tone::kGood});
  page.add(Section{"Doubts"});
  page.add(List{{"The memory limit was not held: 3 of 40 runs.", kHostileText}, Tone::kDoubt});
  page.add(Section{"Plots"});

  IntervalPlot intervals{.caption = {"Ratio to the floor", "Left is better: 1 is the disk itself.",
                                     "plait bench report runs.jsonl --html report.html"},
                         .x = {"seconds over the floor's", "×"},
                         .reference = 1};
  const char* const backends[] = {"memory", "pread", "uring", "mmap", "compressed"};
  for (int disk = 0; disk < 2; ++disk)
    for (int at = 0; at < 5; ++at)
      for (int size = 0; size < 2; ++size) {
        const double value = 1.03 + 0.31 * at + 0.2 * disk + 0.11 * size;
        intervals.points.push_back({disk ? "xfs on /mnt/b" : "ext4 on /mnt/a", backends[at], value,
                                    value * 0.96, value * (1.03 + 0.01 * at), "5 rounds", at == 3});
      }
  page.add(intervals);

  ScatterPlot scatter{
      .caption = {"Size against speed", "Up and left is better.", "plait tune surface.plait"},
      .x = {"stored bytes a vertex", "B"},
      .y = {"decoded bytes a second", "B/s"},
      .points = {{"none", "none", 24, 9e9, true},
                 {"lz4", "shuffle,lz4", 18, 3e9, true, 2.8e9, 3.3e9},
                 {"lz4", "lz4", 23.5, 2.5e9, false},
                 {"zstd", "hierarchy+shuffle,zstd:1", 4, 0.9e9, true},
                 {"zstd", kHostileText, 12, 0.5e9, false}}};
  while (scatter.points.size() < 20)
    scatter.points.push_back({"bitpack", "columns,bitpack",
                              20 + 0.1 * static_cast<double>(scatter.points.size()), 2e8, false});
  page.add(scatter);

  Table table{.caption = {"Every run", "A line for each backend."},
              .columns = {{"backend", false}, {"ratio"}, {"seconds"}, {"state", false}}};
  for (int at = 0; at < 5; ++at)
    table.rows.push_back({{backends[at], "1." + std::to_string(31 * at % 97),
                           at == 2 ? "–" : std::to_string(at) + ".5 s", at == 3 ? "warm" : "cold"},
                          at == 3 ? Tone::kDoubt : Tone::kPlain});
  page.add(table);
  return page;
}

}  // namespace plait::test
