// bench/backends/page_parts.h: the parts of the page of `plait bench report`. findings_page.cpp
// puts them in order.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "backends/findings.h"
#include "instrument/html_page.h"

namespace plait::bench {

/// What every part shows, and where.
struct PageParts {
  const RunSet& set;
  const Findings& findings;
  const std::string& command;  ///< shown under the plots
  instrument::HtmlPage& page;

  instrument::Caption caption(std::string title, std::string how_to_read) const {
    return {std::move(title), std::move(how_to_read), command};
  }
  const CellFigures& first_of(const Contest& contest) const {
    return findings.cells[contest.cells.front()];
  }
  /// Calls `write` for each workload with its contests, in the order of their names.
  template <class Write>
  void for_each_workload(Write write) const {
    std::map<std::string, std::vector<const Contest*>> workloads;
    for (const Contest& contest : findings.contests)
      workloads[work_of(first_of(contest).cell)].push_back(&contest);
    for (const auto& [work, contests] : workloads) write(work, contests);
  }
};

/// The disk, and the size if there is one.
std::string place_of(const MeasuredCell& cell);
/// Cells of tables; a figure that is missing is a dash.
instrument::Cell figure_cell(const std::optional<double>& value, const char* unit = "");

// page_tables.cpp
void write_matrix(const PageParts& parts);
void write_splits(const PageParts& parts);
void write_environment(const PageParts& parts);
void write_latencies(const PageParts& parts);
// page_plots.cpp
void write_ratios(const PageParts& parts);

}  // namespace plait::bench
