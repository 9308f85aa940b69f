// bench/paper/chapter.h: puts the figures of a run (report.h) into the words and tables of the
// chapter about the paper. It measures nothing.
#pragma once

#include <nlohmann/json.hpp>

#include "instrument/page.h"

namespace plait::paper {

/// `report` is what `plait paper --json` prints: that of make_report() (paper/report.h).
instrument::Page make_chapter(const nlohmann::ordered_json& report);

}  // namespace plait::paper
