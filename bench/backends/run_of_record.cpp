#include "backends/run_of_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/read_runs.h"
#include "backends/record_members.h"

namespace plait::bench {
namespace {

using nlohmann::json;

void read_latencies(const json& record, MeasuredRun& run) {
  const json& latencies = member(record, "latencies");
  run.requests = number_of(latencies, "count");
  run.p50 = number_of(latencies, "p50");
  run.p90 = number_of(latencies, "p90");
  run.p99 = number_of(latencies, "p99");
  run.p999 = number_of(latencies, "p999");
  run.longest = number_of(latencies, "max");
}

void read_environment(const json& value, const std::string& prefix,
                      std::map<std::string, std::string>& environment) {
  if (!value.is_object()) return;
  for (const auto& [name, item] : value.items()) {
    if (environment.size() >= 60) return;
    if (item.is_object() && prefix.empty())
      read_environment(item, cut(name) + ".", environment);
    else if (item.is_string())
      environment[prefix + cut(name)] = cut(item.get<std::string>());
    else if (item.is_number() || item.is_boolean())
      environment[prefix + cut(name)] = item.dump();
  }
}

MeasuredCell cell_of(const json& value) {
  if (!value.is_object()) throw BadRecord{"'cell': expected an object"};
  MeasuredCell cell;
  cell.backend = text_of(value, "backend");
  cell.pipeline = text_of(value, "pipeline");
  cell.disk = text_of(value, "disk");
  cell.workload = text_of(value, "workload");
  cell.mesh = text_of(value, "mesh");
  cell.vertices = number_of(value, "vertices");
  cell.levels = number_of(value, "levels");
  cell.memory = number_of(value, "memory");
  cell.budget = number_of(value, "budget");
  cell.ratio = number_of(value, "ratio");
  cell.block_bytes = number_of(value, "block_bytes");
  cell.threads = number_of(value, "threads");
  cell.rate = number_of(value, "rate");
  cell.durable = truth_of(value, "durable").value_or(false);
  if (cell.backend.empty() || cell.workload.empty())
    throw BadRecord{"'cell': expected a backend and a workload"};
  return cell;
}

std::optional<double> sum_of(const json& object, const char* first, const char* second) {
  const std::optional<double> a = number_of(object, first);
  const std::optional<double> b = number_of(object, second);
  return a || b ? std::optional(a.value_or(0) + b.value_or(0)) : std::nullopt;
}

void read_proofs(const json& record, MeasuredRun& run) {
  const json& proofs = member(record, "proofs");
  const json& limit = member(proofs, "limit");
  run.limit_bytes = number_of(limit, "bytes");
  run.limit_held = truth_of(limit, "held");
  run.limit_why_not = text_of(limit, "why_not");
  run.label = text_of(member(proofs, "cold"), "label");
  run.why_warm = text_of(member(proofs, "cold"), "why");
  run.second_cold = number_of(proofs, "second_cold");
  run.checksums = truth_of(proofs, "checksums");
  const json& others = member(proofs, "others");
  const json& surroundings = member(record, "surroundings");
  run.others_busy = number_of(surroundings, "others");
  run.stolen = number_of(surroundings, "stolen");
  run.others_read = number_of(others, "device_read");
  run.others_written = number_of(others, "device_written");
}

}  // namespace

MeasuredRun run_of_record(const json& record) {
  if (!record.is_object()) throw BadRecord{"expected an object"};
  const std::string format = text_of(record, "format");
  if (format != "plait-bench-1")
    throw BadRecord{fmt::format("expected the format plait-bench-1, found '{}'", format)};
  MeasuredRun run;
  const json& key = member(record, "key");
  if (!key.is_string() || key.get_ref<const std::string&>().size() > 4096)
    throw BadRecord{"'key': expected text of at most 4096 bytes"};
  run.key = key.get<std::string>();
  run.cell = cell_of(member(record, "cell"));
  run.round = static_cast<std::uint64_t>(std::min(number_of(record, "round").value_or(0), 1e15));
  run.started = text_of(record, "started");
  run.is_auto = truth_of(record, "auto").value_or(false);
  run.failure = text_of(record, "failure");
  const std::string outcome = text_of(record, "outcome");
  if (outcome != "ok" && outcome != "failed")
    throw BadRecord{fmt::format("'outcome': expected ok or failed, found '{}'", outcome)};
  run.ok = outcome == "ok";
  run.seconds = number_of(record, "seconds").value_or(0);
  if (run.ok && !(run.seconds > 0)) throw BadRecord{"'seconds': expected a number over 0"};
  run.repetitions = number_of(record, "repetitions");
  const json& floor = member(record, "floor");
  run.floor_seconds = number_of(floor, "seconds");
  run.floor_bytes = sum_of(floor, "bytes_read", "bytes_written");
  run.floor_method = text_of(floor, "method");
  const json& by_fio = member(record, "floor_by_fio");
  run.fio_seconds = number_of(by_fio, "seconds");
  run.fio_bytes = sum_of(by_fio, "bytes_read", "bytes_written");
  run.ratio = number_of(record, "ratio");
  if (run.ratio && !(*run.ratio > 0)) throw BadRecord{"'ratio': expected a number over 0"};

  const json& bytes = member(record, "bytes");
  run.needed_read = number_of(bytes, "needed_read");
  run.needed_written = number_of(bytes, "needed_written");
  run.moved_read = number_of(bytes, "moved_read");
  run.moved_written = number_of(bytes, "moved_written");
  run.device_read = number_of(bytes, "device_read");
  run.device_written = number_of(bytes, "device_written");
  run.process_moved = sum_of(bytes, "process_read", "process_written");
  run.stored = number_of(bytes, "stored");
  const json& split = member(record, "split");
  run.compute = number_of(split, "compute");
  run.wait = number_of(split, "wait");
  run.codec = number_of(split, "codec");
  run.sync = number_of(split, "sync");
  read_latencies(record, run);
  run.minor_faults = number_of(member(record, "faults"), "minor");
  run.major_faults = number_of(member(record, "faults"), "major");
  run.peak_rss = number_of(record, "peak_rss");
  run.user_seconds = number_of(member(record, "processor"), "user");
  run.system_seconds = number_of(member(record, "processor"), "system");
  read_proofs(record, run);
  run.digest_of = text_of(member(record, "digest"), "of");
  run.digest = text_of(member(record, "digest"), "value");
  const json& doubts = member(record, "doubts");
  if (!doubts.is_null() && !doubts.is_array()) throw BadRecord{"'doubts': expected a list"};
  for (const json& doubt : doubts) {
    if (!doubt.is_string()) throw BadRecord{"'doubts': expected lines of text"};
    if (run.doubts.size() < 20) run.doubts.push_back(cut(doubt.get<std::string>()));
  }
  read_environment(member(record, "environment"), "", run.environment);
  return run;
}

}  // namespace plait::bench
