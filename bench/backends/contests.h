// bench/backends/contests.h: which of several cells that do the same work is the fastest.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "backends/findings.h"

namespace plait::bench {

/// The cells grouped by disk, work, size and memory, ranked, and compared with the fastest of their
/// group: paired by round, on the logarithms of seconds. The three answers are corrected for how
/// many comparisons there are, and for the choice of the fastest among many. A cell of which a run
/// failed is not ranked: its outcome is in the table, and nobody should use it. Pinned by
/// tests/bench/backends/report_test.cpp.
std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells);

/// The keys of cells that need no more rounds: those shown to be slower than the fastest by a fifth
/// after four rounds, and those of groups in which each other cell is such a one, or known within 5
/// %. Nothing here depends on which answer came out, so leaving early makes no answer likelier.
std::set<std::string> settled_keys(const RunSet& set);

}  // namespace plait::bench
