// bench/runs/report_page.h: findings on a terminal, as a page and as JSON. What a reader needs
// first stands first on both: how much is known, a matrix of disk by workload, and a line of
// advice for each disk.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "instrument/page.h"
#include "runs/findings.h"

namespace plait::bench {

/// What a terminal shows: the first screen with the doubts, and the figures of the cells if they
/// are few.
std::string to_text(const RunSet& set, const Findings& findings);
/// All of it. `command` is shown under plots and tables.
std::string to_page(const RunSet& set, const Findings& findings, const std::string& command);
/// {verdict, advice, failed, doubts, cells, comparisons, runs, skipped}.
nlohmann::ordered_json to_json(const RunSet& set, const Findings& findings);

/// "The choice is known for 5 of 6 workloads, for 2 of them as one of two; 11 must never be
/// taken.", and how good `auto` is.
std::string verdict_of(const Findings& findings);
/// "auto is at most 8 % behind the fastest in 14 of 15 comparisons; the farthest is 2.1 times, for
/// scan-export on ext4 (uring)." Empty if no run was of `auto`'s choice.
std::string text_about_auto(const Findings& findings);
/// A row for each contest with anything to compare, by disk, workload and size: what to take
/// ("uring or compressed, fast; which of the two: 2 more minutes"), what is known of the others
/// ("pread 1.40 to 1.70 times as long"), and what takes twice the time or fails ("mmap, 6.1
/// times; pread, 1 of 4 survived").
instrument::Table matrix_table(const Findings& findings);
/// "On ext4, 2 × memory: pread is among the best for 12 of 15 workloads."
std::vector<std::string> advice_of(const Findings& findings);

}  // namespace plait::bench
