// bench/runs/read_runs.h: reads the records of `plait bench run`, from any machine and any
// hand.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plait::bench {

/// A figure that was not measured is null in records and reports.
nlohmann::ordered_json or_null(bool known, const auto& value) {
  return known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}
template <class Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// What was measured: equal for runs that repeat the same measurement.
struct MeasuredCell {
  std::string backend, pipeline, disk, workload;
  std::string mesh;  ///< empty: a torus
  std::optional<double> vertices, levels, memory, budget, ratio, block_bytes, threads;
  bool durable = false;
};
/// The members of `cell` in a record, and in a report.
constexpr std::pair<const char*, std::string MeasuredCell::*> kTextsOfCell[] = {
    {"backend", &MeasuredCell::backend},
    {"pipeline", &MeasuredCell::pipeline},
    {"disk", &MeasuredCell::disk},
    {"workload", &MeasuredCell::workload},
    {"mesh", &MeasuredCell::mesh}};
constexpr std::pair<const char*, std::optional<double> MeasuredCell::*> kNumbersOfCell[] = {
    {"vertices", &MeasuredCell::vertices}, {"levels", &MeasuredCell::levels},
    {"memory", &MeasuredCell::memory},     {"budget", &MeasuredCell::budget},
    {"ratio", &MeasuredCell::ratio},       {"block_bytes", &MeasuredCell::block_bytes},
    {"threads", &MeasuredCell::threads}};

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
      device_written;
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
  /// Empty if it is not known.
  std::string environment_at(const std::string& name) const {
    const auto found = environment.find(name);
    return found == environment.end() ? std::string() : found->second;
  }
};

constexpr std::size_t kMostLineBytes = 1 << 20;
constexpr std::size_t kMostRuns = 100'000;

struct RunSet {
  std::vector<MeasuredRun> runs;
  std::uint64_t skipped = 0;
  std::vector<std::string> skipped_lines;  ///< "FILE:LINE: why", the first ten
};

/// Reads records, a line each. A line that is no record (cut, too long, a value of the wrong type,
/// a number that no double holds, an unknown format) is skipped and counted. A last line without a
/// newline is skipped, because its writer was stopped. Memory: bounded by the constants above.
/// Errors: kNotFound, kIo; kInvalidArgument naming the first bad line if no record is left.
/// REQUIRES: a file.
RunSet read_runs(const std::vector<std::filesystem::path>& files);

/// The runs of records that this process made. `name` stands for their file. Errors:
/// kInvalidArgument naming the first record that is none.
RunSet runs_of(const std::vector<nlohmann::ordered_json>& records, const std::string& name);

}  // namespace plait::bench
