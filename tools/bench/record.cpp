#include "bench/record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "plait/byte_text.h"
#include "plait/version.h"

namespace plait::bench {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return {};
}

std::uint64_t memory_of_machine() {
  std::ifstream file("/proc/meminfo");
  std::string word;
  std::uint64_t kibibytes = 0;
  file >> word >> kibibytes;
  return kibibytes * 1024;
}

nlohmann::ordered_json known(const instrument::DiskCounters& counters, std::uint64_t value) {
  return counters.known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::uint64_t beyond(std::uint64_t all, std::uint64_t own) { return all > own ? all - own : 0; }

}  // namespace

ColdLabel cold_label(const instrument::DiskFacts& disk, const Observed& observed,
                     const nlohmann::ordered_json& result) {
  if (disk.in_memory) return {"memory", ""};
  if (!observed.asked_cold) return {"warm", "warm: the page cache was left as it was"};
  if (!instrument::is_cold(observed.before))
    return {"warm", fmt::format("warm: {:.0f} % of the files were in the page cache before",
                                100 * observed.before.share())};
  if (result["process_read"].is_null())
    return {"warm", "warm: the kernel does not count what the disk read, so cold is not proved"};
  const auto read = result["process_read"].get<std::uint64_t>();
  const auto stored = result["stored"].get<std::uint64_t>();
  // Where a part of the store is enough, what the pager moved says how much; stored bytes of
  // compressed blocks are not known one by one, so a tenth of it is asked for.
  const std::uint64_t least =
      observed.reads_all ? stored / 2
                         : std::min(stored, result["moved_read"].get<std::uint64_t>()) / 10;
  if (read < least)
    return {"warm", fmt::format("warm: the disk read {} of {}, so a cache gave the rest",
                                format_bytes(read), format_bytes(stored))};
  return {"cold", ""};
}

nlohmann::ordered_json environment(const instrument::DiskFacts& disk) {
  utsname names{};
  ::uname(&names);
  return {{"plait", PLAIT_VERSION},
          {"commit", nullptr},
          {"kernel", fmt::format("{} {}", names.sysname, names.release)},
          {"processor", processor_name()},
          {"processors", std::thread::hardware_concurrency()},
          {"memory", memory_of_machine()},
          {"disk", instrument::to_json(disk)}};
}

nlohmann::ordered_json empty_record(const Cell& cell, int round, int order, std::uint64_t seed) {
  nlohmann::ordered_json record = {{"format", "plait-bench-1"},
                                   {"key", key_of(cell)},
                                   {"cell", to_json(cell)},
                                   {"round", round},
                                   {"order", order},
                                   {"seed", seed}};
  record["started"] = fmt::format(
      "{:%Y-%m-%dT%H:%M:%SZ}",
      fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  record["outcome"] = "failed";
  for (const char* name :
       {"failure", "seconds", "floor", "floor_by_fio", "ratio", "bytes", "split", "latencies",
        "open_loop", "throughput", "faults", "peak_rss", "processor", "proofs", "digest"})
    record[name] = nullptr;
  record["doubts"] = nlohmann::ordered_json::array();
  return record;
}

void add_result(nlohmann::ordered_json& record, const nlohmann::ordered_json& result,
                const Observed& observed, const instrument::DiskFacts& disk) {
  record["outcome"] = "ok";
  for (const char* name : {"seconds", "split", "latencies", "open_loop", "throughput", "digest"})
    if (result.contains(name)) record[name] = result[name];
  record["bytes"] = {{"needed_read", result["needed_read"]},
                     {"needed_written", result["needed_written"]},
                     {"moved_read", result["moved_read"]},
                     {"moved_written", result["moved_written"]},
                     {"device_read", known(observed.device, observed.device.bytes_read)},
                     {"device_written", known(observed.device, observed.device.bytes_written)},
                     {"process_read", result["process_read"]},
                     {"process_written", result["process_written"]},
                     {"blocks_read", result["blocks_read"]},
                     {"stored", result["stored"]}};
  record["faults"] = {{"minor", observed.process.minor_faults},
                      {"major", observed.process.major_faults}};
  record["peak_rss"] = observed.process.peak_rss_bytes;
  record["processor"] = {{"user", observed.process.user_seconds},
                         {"system", observed.process.system_seconds}};
  nlohmann::ordered_json& proofs = record["proofs"];
  proofs["checksums"] = true;
  proofs["mode"] = result["mode"];
  proofs["cold"] = nullptr;
  if (result["needed_read"] != 0) {
    const ColdLabel label = cold_label(disk, observed, result);
    proofs["cold"] = {{"asked", observed.asked_cold},
                      {"label", label.label},
                      {"resident_before", observed.before.share()},
                      {"device_read", result["process_read"]},
                      {"needed_read", result["needed_read"]}};
    if (!label.doubt.empty()) record["doubts"].push_back(label.doubt);
  }
  proofs["others"] = nullptr;
  if (observed.device.known && !result["process_read"].is_null()) {
    const std::uint64_t read =
        beyond(observed.device.bytes_read, result["process_read"].get<std::uint64_t>());
    const std::uint64_t written =
        beyond(observed.device.bytes_written, result["process_written"].get<std::uint64_t>());
    proofs["others"] = {{"device_read", read}, {"device_written", written}};
    const std::uint64_t own = result["process_read"].get<std::uint64_t>() +
                              result["process_written"].get<std::uint64_t>();
    if (10 * (read + written) > own && read + written > (16u << 20))
      record["doubts"].push_back(
          fmt::format("others: the device moved {} for other programs or caches meanwhile",
                      format_bytes(read + written)));
  }
}

void add_floor(nlohmann::ordered_json& record, const instrument::FloorRequest& request,
               const instrument::FloorResult& floor,
               const std::optional<instrument::FloorResult>& by_fio) {
  nlohmann::ordered_json object = instrument::to_json(floor);
  object["kind"] = instrument::to_string(request.kind);
  object["direct"] = request.direct;
  object["block_bytes"] = request.block_bytes;
  object["threads"] = request.threads;
  record["floor"] = object;
  if (by_fio) {
    record["floor_by_fio"] = instrument::to_json(*by_fio);
    const double own = 1 / floor.bytes_per_second(), other = 1 / by_fio->bytes_per_second();
    if (!instrument::agree(own, other))
      record["doubts"].push_back(
          fmt::format("floor: fio moves {}/s where our own program moves {}/s",
                      format_bytes(static_cast<std::uint64_t>(1 / other)),
                      format_bytes(static_cast<std::uint64_t>(1 / own))));
  }
  if (!record["seconds"].is_number()) return;
  const nlohmann::ordered_json& cold = record["proofs"]["cold"];
  const bool run_is_warm = cold.is_object() && cold["label"] == "warm";
  if (cold.is_object() && cold["label"] != "memory" && run_is_warm == floor.cold) {
    record["doubts"].push_back(run_is_warm ? "no ratio: the run was warm and its floor cold"
                                           : "no ratio: the floor was warm and the run cold");
    return;
  }
  record["ratio"] = record["seconds"].get<double>() / floor.seconds;
}

}  // namespace plait::bench
