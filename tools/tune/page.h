// tools/tune/page.h: what `plait tune` found, as one page of HTML.
#pragma once

#include <string>

#include "tune/report.h"

namespace plait::tune {

/// A page with plots and tables, which refers to nothing outside of itself. It contains to_json().
std::string to_html(const Findings& findings, const Advice& advice);

}  // namespace plait::tune
