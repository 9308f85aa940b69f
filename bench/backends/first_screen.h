// bench/backends/first_screen.h: what a reader needs first, on a terminal and on a page: a matrix
// of disk by workload, a line of advice for each disk, and how much is decided.
#pragma once

#include <string>
#include <vector>

#include "backends/findings.h"
#include "instrument/page.h"

namespace plait::bench {

/// A row for each contest with anything to compare, by disk, workload and size: the fastest
/// ("compressed, fast or compressed, default" if only pipelines of one backend are open), who is
/// equal to it ("uring equal within 5 %; mmap 1.4 to 1.7 times as long"), and who takes twice the
/// time or fails ("never compressed (2 of 5 survived)").
instrument::Table matrix_table(const Findings& findings);

/// "On ext4: use pread, among the fastest in 12 of 15; never mmap for sweep-read (9 times as
/// long)."
std::vector<std::string> advice_of(const Findings& findings);

/// "auto is at most 8 % behind the fastest in 14 of 15 comparisons; the farthest is 2.1 times, for
/// scan-export on ext4 (uring)." Empty if no run was of `auto`'s choice.
std::string text_about_auto(const Findings& findings);

/// "41 of 60 comparisons are decided, and 9 more but for the pipeline.", and how good `auto` is.
std::string verdict_of(const Findings& findings);

}  // namespace plait::bench
