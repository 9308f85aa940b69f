// bench/instrument/svg_plots.h: draws the plots of a page (page.h) as SVG in HTML. Every mark has
// its value and what it is in a title, which browsers show under the pointer.
#pragma once

#include <string>
#include <vector>

#include "instrument/page.h"

namespace plait::instrument {

/// The names that have a colour and a shape, each by its place here.
using SeriesNames = std::vector<std::string>;

/// Adds names that are new to `series`, so that a name looks the same on the whole page. Marks have
/// their values in data-value, or in data-x and data-y, and grid lines in data-tick. Pinned by
/// page_test.cpp.
std::string svg_plot(const IntervalPlot& plot, SeriesNames& series);
std::string svg_plot(const ScatterPlot& plot, SeriesNames& series);

}  // namespace plait::instrument
