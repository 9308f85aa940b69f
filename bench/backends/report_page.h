// bench/backends/report_page.h: findings as a page.
#pragma once

#include <string>

#include "backends/findings.h"
#include "instrument/page.h"

namespace plait::bench {

/// The figures of each cell. On the terminal if they are few.
instrument::Table figures_table(const RunSet& set, const Findings& findings);
/// All of it. `command` is shown under plots and tables.
std::string to_page(const RunSet& set, const Findings& findings, const std::string& command);

}  // namespace plait::bench
