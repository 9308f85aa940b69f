// bench/backends/read_runs.h: reads the records of `plait bench run`, from any machine and any
// hand.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "backends/measured_run.h"

namespace plait::bench {

constexpr std::size_t kMostLineBytes = 1 << 20;
constexpr std::size_t kMostRuns = 100'000;
constexpr std::size_t kMostRunsOfCell = 2000;
constexpr std::size_t kMostText = 200;  ///< characters of a name; longer ones are cut

/// A record that cannot be believed.
struct BadRecord {
  std::string why;
};
/// One record as a run; the caller fills in `file` and `line`. Throws BadRecord for what is no
/// record. Pinned by tests/bench/backends/report_test.cpp.
MeasuredRun run_of_record(const nlohmann::json& record);
/// Long text is cut between characters.
std::string cut(std::string text);

struct RunSet {
  std::vector<MeasuredRun> runs;
  std::uint64_t skipped = 0;
  std::vector<std::string> skipped_lines;  ///< "FILE:LINE: why", the first ten
};

/// Reads records, a line each. A line that is no record (cut, too long, a value of the wrong type,
/// a number that no double holds, an unknown format) is skipped and counted. A last line without a
/// newline is skipped, because its writer was stopped. Memory: bounded by the constants above.
/// Errors: kNotFound, kIo; kInvalidArgument naming the first bad line if no record is left.
RunSet read_runs(const std::vector<std::filesystem::path>& files);

/// The runs of records that this process made. `name` stands for their file. Errors:
/// kInvalidArgument naming the first record that is none.
RunSet runs_of(const std::vector<nlohmann::ordered_json>& records, const std::string& name);

}  // namespace plait::bench
