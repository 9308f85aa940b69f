// bench/runs/report_page.h: findings on a terminal, as a page and as JSON. What a reader needs
// first stands first on both: how much is decided, a matrix of disk by workload, and a line of
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

/// "41 of 60 comparisons are decided, and 7 more but for the pipeline.", and how good `auto` is.
std::string verdict_of(const Findings& findings);
/// "auto is at most 8 % behind the fastest in 14 of 15 comparisons; the farthest is 2.1 times, for
/// scan-export on ext4 (uring)." Empty if no run was of `auto`'s choice.
std::string text_about_auto(const Findings& findings);
/// A row for each contest with anything to compare, by disk, workload and size: the fastest
/// ("compressed, fast or compressed, default" if only pipelines of one backend are open), who is
/// equal to it ("uring equal within 5 %; mmap 1.4 to 1.7 times as long"), and who takes twice the
/// time or fails ("never compressed (2 of 5 survived)").
instrument::Table matrix_table(const Findings& findings);
/// "On ext4: use pread, among the fastest in 12 of 15; never mmap for sweep-read (9 times as
/// long)."
std::vector<std::string> advice_of(const Findings& findings);

}  // namespace plait::bench
