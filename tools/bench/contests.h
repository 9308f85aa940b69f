// bench/contests.h: which of several cells that do the same work is the fastest.
#pragma once

#include <vector>

#include "bench/findings.h"

namespace plait::bench {

/// The cells grouped by disk, work, size and memory, and ranked.
std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells);

/// One sentence about all contests.
std::string verdict_of(const Findings& findings);

}  // namespace plait::bench
