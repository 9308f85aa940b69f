#include "backends/record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>

namespace plait::bench {
namespace {

std::uint64_t beyond(std::uint64_t all, std::uint64_t own) { return all > own ? all - own : 0; }

}  // namespace

ColdLabel cold_label(const instrument::DiskFacts& disk, const Observed& observed,
                     const nlohmann::ordered_json& result) {
  if (disk.in_memory) return {"memory", ""};
  if (!observed.asked_cold) return {"warm", "the page cache was left as it was"};
  if (!instrument::is_cold(observed.before))
    return {"warm", "the page cache had files of the store before the run"};
  const nlohmann::ordered_json& bytes = result["bytes"];
  if (bytes["process_read"].is_null())
    return {"warm", "the kernel does not count what the disk read, so cold is not proved"};
  const auto read = bytes["process_read"].get<std::uint64_t>();
  const auto stored = bytes["stored"].get<std::uint64_t>();
  // Where a part of the store is enough, what the pager moved says how much; stored bytes of
  // compressed blocks are not known one by one, so a tenth of it is asked for.
  const std::uint64_t least = observed.reads_all
                                  ? stored / 2
                                  : std::min(stored, bytes["moved_read"].get<std::uint64_t>()) / 10;
  if (read < least) return {"warm", "the disk read too little, so a cache gave the rest"};
  return {"cold", ""};
}

nlohmann::ordered_json empty_record(const Cell& cell, int round, int order, std::uint64_t seed) {
  nlohmann::ordered_json record = {{"format", "plait-bench-1"},
                                   {"key", key_of(cell)},
                                   {"cell", to_json(cell)},
                                   {"round", round},
                                   {"order", order},
                                   {"seed", seed},
                                   {"auto", cell.is_auto}};
  record["started"] = fmt::format(
      "{:%Y-%m-%dT%H:%M:%SZ}",
      fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  record["outcome"] = "failed";
  for (const char* name : {"failure", "seconds", "repetitions", "floor", "floor_by_fio", "ratio",
                           "bytes", "split", "latencies", "open_loop", "faults", "peak_rss",
                           "processor", "proofs", "surroundings", "digest"})
    record[name] = nullptr;
  record["doubts"] = nlohmann::ordered_json::array();
  return record;
}

void add_result(nlohmann::ordered_json& record, const nlohmann::ordered_json& result,
                const Observed& observed, const instrument::DiskFacts& disk) {
  record["outcome"] = "ok";
  for (const char* name : {"seconds", "bytes", "split", "latencies", "open_loop", "digest"})
    if (result.contains(name)) record[name] = result[name];
  record["faults"] = {{"minor", observed.process.minor_faults},
                      {"major", observed.process.major_faults}};
  record["peak_rss"] = observed.process.peak_rss_bytes;
  record["processor"] = {{"user", observed.process.user_seconds},
                         {"system", observed.process.system_seconds}};
  nlohmann::ordered_json& proofs = record["proofs"];
  proofs["checksums"] = true;
  proofs["mode"] = result["mode"];
  proofs["cold"] = nullptr;
  const nlohmann::ordered_json& bytes = result["bytes"];
  if (bytes["needed_read"] != 0) {
    const ColdLabel label = cold_label(disk, observed, result);
    proofs["cold"] = {{"asked", observed.asked_cold},
                      {"label", label.label},
                      {"why", nullptr},
                      {"resident_before", observed.before.share()},
                      {"device_read", bytes["process_read"]},
                      {"needed_read", bytes["needed_read"]}};
    if (!label.why.empty()) proofs["cold"]["why"] = label.why;
  }
  proofs["others"] = nullptr;
  if (!bytes["device_read"].is_null() && !bytes["process_read"].is_null()) {
    const auto others = [&](const char* device, const char* process) {
      return beyond(bytes[device].get<std::uint64_t>(), bytes[process].get<std::uint64_t>());
    };
    proofs["others"] = {{"device_read", others("device_read", "process_read")},
                        {"device_written", others("device_written", "process_written")}};
  }
}

void add_floor(nlohmann::ordered_json& record, const instrument::FloorRequest& request,
               const instrument::FloorResult& floor,
               const std::optional<instrument::FloorResult>& by_fio) {
  nlohmann::ordered_json object = nlohmann::json(floor);
  object["kind"] = instrument::to_string(request.kind);
  object["direct"] = request.direct;
  object["block_bytes"] = request.block_bytes;
  object["threads"] = request.threads;
  record["floor"] = object;
  if (by_fio) record["floor_by_fio"] = nlohmann::json(*by_fio);
  if (!record["seconds"].is_number()) return;
  const nlohmann::ordered_json& cold = record["proofs"]["cold"];
  const bool run_is_warm = cold.is_object() && cold["label"] == "warm";
  if (cold.is_object() && cold["label"] != "memory" && run_is_warm == floor.cold) return;
  record["ratio"] = record["seconds"].get<double>() / floor.seconds;
}

}  // namespace plait::bench
