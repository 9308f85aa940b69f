// bench/backends/report_page.h: findings on a terminal and as a page.
#pragma once

#include <string>

#include "backends/findings.h"

namespace plait::bench {

/// What a terminal shows: the first screen (first_screen.h) with the doubts, and the figures of the
/// cells if they are few.
std::string to_text(const RunSet& set, const Findings& findings);

/// All of it. `command` is shown under plots and tables.
std::string to_page(const RunSet& set, const Findings& findings, const std::string& command);

}  // namespace plait::bench
