// bench/backends/read_runs.h: reads the records of `plait bench run`, from any machine and any
// hand.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plait::bench {

/// What was measured: equal for runs that repeat the same measurement.
struct MeasuredCell {
  std::string backend, pipeline, disk, workload;
  std::string mesh;  ///< empty: a torus
  std::optional<double> vertices, levels, memory, budget, ratio, block_bytes, threads, rate;
  bool durable = false;
};

/// Figures that a run did not measure are empty.
struct MeasuredRun {
  std::string file;  ///< where the record is
  std::uint64_t line = 0;

  std::string key;
  MeasuredCell cell;
  std::uint64_t round = 0;
  std::string started, failure;
  bool ok = false, is_auto = false;
  double seconds = 0;  ///< if ok: positive
  std::optional<double> floor_seconds, floor_bytes, fio_seconds, fio_bytes, ratio;
  std::optional<double> repetitions;  ///< how often the work was done; `seconds` is of once

  std::optional<double> needed_read, needed_written, moved_read, moved_written, device_read,
      device_written, process_moved;
  std::optional<double> compute, wait, codec, sync;
  std::optional<double> p50, p99, p999;

  /// Shares of the processors that other programs and other machines had meanwhile.
  std::optional<double> others_busy, stolen;

  std::string label;  ///< "cold", "warm", "memory", or empty
  std::string why_warm, limit_why_not;
  std::optional<bool> limit_held, checksums;
  std::optional<double> limit_bytes, second_cold, others_read, others_written;
  std::string digest_of, digest;
  std::vector<std::string> doubts;
  /// Dotted names ("disk.scheduler") and values as text, in the order of the names.
  std::map<std::string, std::string> environment;
};

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
