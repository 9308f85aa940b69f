// bench/run_table.h: what a terminal shows of records: a table, and one sentence.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plait::bench {

/// A row for each cell: the ratio to its floor first. "1.05 (1.01 to 1.20)" is a median and the
/// smallest and largest value. Cells without a ratio say why.
std::string run_table(const std::vector<nlohmann::ordered_json>& records);

/// The fastest backend of each disk and workload, if the intervals of the medians leave no doubt;
/// else "undecided". FAILED comes first, if digests differ.
std::string verdict(const std::vector<nlohmann::ordered_json>& records);

}  // namespace plait::bench
