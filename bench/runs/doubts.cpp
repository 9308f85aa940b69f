#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>

#include "instrument/surroundings.h"
#include "runs/findings.h"

namespace plait::bench {
namespace {

/// Our own floor and fio's may differ by this share.
constexpr double kFloorsAgree = 0.10;
constexpr double kFasterSecondCold = 1.25;
/// Traffic of other programs, beside that of the run, and as much as says nothing: file systems
/// write their journals.
constexpr double kOtherPrograms = 0.05, kOtherBytes = 16 << 20;

/// The message without paths and numbers: failures that differ in nothing else are of one kind.
std::string kind_of(const std::string& message) {
  static const std::regex kPathsAndDigits(R"(\S*/\S*|[0-9])");
  return std::regex_replace(message, kPathsAndDigits, "");
}

/// Doubts of runs: one line for each kind, with how many runs have it.
class Doubts {
 public:
  /// The line of a kind shows `what` of the first run that has it.
  void add(const std::string& kind, const std::string& what) {
    if (kinds_.size() == 100 && !kinds_.contains(kind)) return;
    if (Kind& of = kinds_[kind]; of.runs++ == 0) of.what = what;
  }
  void append_to(std::vector<std::string>& lines, std::size_t runs) const {
    for (const auto& [kind, of] : kinds_)
      lines.push_back(fmt::format("{} ({} of {} runs)", of.what, of.runs, runs));
  }

 private:
  struct Kind {
    std::string what;
    std::uint64_t runs = 0;
  };
  std::map<std::string, Kind> kinds_;
};

/// Why the page cache may have served a run that was not to be served by it; empty: it did not.
std::string limit_doubt(const MeasuredRun& run) {
  // Where files are in memory, no page cache stands before a disk.
  if (!run.limit_bytes || run.environment_at("disk.in_memory") == "true") return {};
  const bool limited = *run.limit_bytes > 0;
  if (limited && run.limit_held.value_or(false)) return {};
  return fmt::format(
      "{}{}, so the page cache may have helped",
      limited ? "the memory limit was not held" : "there was no memory limit",
      run.limit_why_not.empty() ? std::string() : fmt::format(" ({})", run.limit_why_not));
}

bool floors_differ(const MeasuredRun& run) {
  if (!run.floor_seconds || !run.fio_seconds) return false;
  // fio may move fewer bytes than it was asked for; a floor without a count moved the same.
  const double own = *run.floor_seconds / run.floor_bytes.value_or(1);
  const double fio =
      *run.fio_seconds / (run.floor_bytes ? run.fio_bytes.value_or(*run.floor_bytes) : 1);
  return std::abs(own - fio) > kFloorsAgree * std::min(own, fio);
}

bool others_used_device(const MeasuredRun& run) {
  const double others = run.others_read.value_or(0) + run.others_written.value_or(0);
  const double own = run.device_read.value_or(0) + run.device_written.value_or(0) - others;
  return others > kOtherBytes && others > kOtherPrograms * own;
}

void add_doubts_of_run(const MeasuredRun& run, Doubts& spoiling, Doubts& doubts) {
  if (!run.ok) {
    const std::string why =
        run.failure.empty() ? "for a reason that the record does not say" : run.failure;
    return doubts.add("failed: " + kind_of(why), "failed: " + why);
  }
  if (const std::string limit = limit_doubt(run); !limit.empty()) spoiling.add(limit, limit);
  const auto check = [&](bool fails, const std::string& doubt) {
    if (fails) doubts.add(doubt, doubt);
  };
  check(run.label == "warm",
        fmt::format("warm: {}, so this is no figure of a disk",
                    run.why_warm.empty() ? "the page cache held the data" : run.why_warm));
  check(run.second_cold.value_or(0) > kFasterSecondCold,
        "a second cold read was faster: there is a cache below this machine");
  check(floors_differ(run), "our floor and fio's differ by more than 10 %");
  check(run.others_busy.value_or(0) + run.stolen.value_or(0) > instrument::kDisturbed,
        "other programs or machines had more than a tenth of the processors");
  check(others_used_device(run), "other programs used the device during the run");
  check(!run.checksums.value_or(true), "checksums were not verified");
  for (const std::string& doubt : run.doubts) check(true, doubt);
}

void add_doubts_of_cells(const std::vector<CellFigures>& cells, std::vector<std::string>& lines) {
  const auto no_floor = std::ranges::count_if(
      cells, [](const CellFigures& figures) { return figures.seconds && !figures.ratio; });
  if (no_floor > 0)
    lines.push_back(fmt::format(
        "{} of {} cells have no floor beside them, or one that was warm where the run was cold",
        no_floor, cells.size()));
}

/// Runs of several machines or versions in one report may be meant, but have to be seen.
void add_doubts_of_environment(const RunSet& set, std::vector<std::string>& lines) {
  for (const auto& [name, what] :
       {std::pair("commit", "versions of plait"), std::pair("kernel", "kernels"),
        std::pair("processor", "processors")}) {
    std::set<std::string> values;
    for (const MeasuredRun& run : set.runs)
      if (values.size() < 100) values.insert(run.environment_at(name));
    values.erase("");
    if (values.size() > 1)
      lines.push_back(fmt::format("the runs come from {} {}: {}", values.size(), what,
                                  fmt::join(values, ", ")));
  }
}

}  // namespace

void add_doubts(const RunSet& set, Findings& findings) {
  Doubts spoiling, others;
  for (const MeasuredRun& run : set.runs) add_doubts_of_run(run, spoiling, others);
  std::vector<std::string>& lines = findings.doubts;
  lines = digest_failures(set.runs);
  findings.failed = !lines.empty();
  spoiling.append_to(lines, set.runs.size());
  findings.spoiling = lines.size();
  others.append_to(lines, set.runs.size());
  add_doubts_of_cells(findings.cells, lines);
  add_doubts_of_environment(set, lines);
  if (set.skipped > 0)
    lines.push_back(fmt::format("{} lines are no records and were skipped", set.skipped));
  lines.insert(lines.end(), set.skipped_lines.begin(), set.skipped_lines.end());
}

}  // namespace plait::bench
