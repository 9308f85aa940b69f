// bench/backends/measured_run.h: one record of `plait bench run` as the report needs it
// (docs/bench.md).
#pragma once

#include <cstdint>
#include <map>
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
  std::optional<double> p50, p90, p99, p999, longest;

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

}  // namespace plait::bench
