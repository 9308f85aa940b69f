// bench/backends/findings_page.h: the page of `plait bench report`.
#pragma once

#include <string>

#include "backends/findings.h"

namespace plait::bench {

/// A page that needs nothing but itself (instrument/html_page.h). `command` made it, and is shown
/// under the plots. Its element "report" holds to_json(set, findings).
std::string to_page(const RunSet& set, const Findings& findings, const std::string& command);

}  // namespace plait::bench
