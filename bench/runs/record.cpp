#include "runs/record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <utility>

#include "plait/error.h"
#include "runs/read_runs.h"

namespace plait::bench {

namespace fs = std::filesystem;

nlohmann::ordered_json to_json(const Cell& cell) {
  return {{"backend", cell.backend},
          {"pipeline", cell.pipeline},
          {"disk", cell.disk},
          {"workload", cell.workload},
          {"mesh", or_null(!cell.mesh.empty(), cell.mesh)},
          {"vertices", cell.vertices},
          {"levels", cell.levels},
          {"memory", cell.memory_bytes},
          {"budget", cell.budget_bytes},
          {"ratio", static_cast<double>(cell.raw_bytes()) / static_cast<double>(cell.memory_bytes)},
          {"block_bytes", cell.block_bytes},
          {"threads", cell.threads},
          {"durable", true}};
}

std::string key_of(const Cell& cell) { return to_json(cell).dump(); }

std::string store_name(const Cell& cell) {
  std::string name = fmt::format("{}-{}-{}-{}-{}-{}.plait", cell.backend, cell.pipeline, cell.mesh,
                                 cell.base_vertices, cell.levels, cell.block_bytes);
  std::ranges::replace(name, '/', '_');
  return name;
}

std::string surface_name(const Cell& cell) {
  return fmt::format("{}{} vertices at level {}", cell.mesh.empty() ? "" : cell.mesh + ", ",
                     cell.base_vertices, cell.levels);
}

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
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  nlohmann::ordered_json record = {
      {"format", "plait-bench-1"},
      {"key", key_of(cell)},
      {"cell", to_json(cell)},
      {"round", round},
      {"order", order},
      {"seed", seed},
      {"auto", cell.is_auto},
      {"started", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now))},
      {"outcome", "failed"}};
  for (const char* name :
       {"failure", "seconds", "repetitions", "floor", "floor_by_fio", "ratio", "bytes", "split",
        "latencies", "faults", "peak_rss", "processor", "proofs", "surroundings", "digest"})
    record[name] = nullptr;
  record["doubts"] = nlohmann::ordered_json::array();
  return record;
}

void add_result(nlohmann::ordered_json& record, const nlohmann::ordered_json& result,
                const Observed& observed, const instrument::DiskFacts& disk) {
  record["outcome"] = "ok";
  for (const char* name : {"seconds", "bytes", "split", "latencies", "digest"})
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
  proofs["others"] = nullptr;
  const nlohmann::ordered_json& bytes = result["bytes"];
  if (bytes["needed_read"] != 0) {
    const ColdLabel label = cold_label(disk, observed, result);
    proofs["cold"] = {{"asked", observed.asked_cold},
                      {"label", label.label},
                      {"why", or_null(!label.why.empty(), label.why)},
                      {"resident_before", observed.before.share()},
                      {"device_read", bytes["process_read"]},
                      {"needed_read", bytes["needed_read"]}};
  }
  if (bytes["device_read"].is_null() || bytes["process_read"].is_null()) return;
  const auto others = [&](const std::string& direction) {
    const auto all = bytes["device_" + direction].get<std::uint64_t>();
    return all - std::min(all, bytes["process_" + direction].get<std::uint64_t>());
  };
  proofs["others"] = {{"device_read", others("read")}, {"device_written", others("written")}};
}

void add_floor(nlohmann::ordered_json& record, const instrument::FloorRequest& request,
               const RoundFloor& floor) {
  nlohmann::ordered_json& object = record["floor"] = nlohmann::json(floor.own);
  object["kind"] = instrument::to_string(request.kind);
  object["direct"] = request.direct;
  object["block_bytes"] = request.block_bytes;
  object["threads"] = request.threads;
  if (floor.by_fio) record["floor_by_fio"] = nlohmann::json(*floor.by_fio);
  record["proofs"]["second_cold"] = or_null(floor.second_cold);
  if (!record["seconds"].is_number()) return;
  const nlohmann::ordered_json& cold = record["proofs"]["cold"];
  const bool run_is_warm = cold.is_object() && cold["label"] == "warm";
  if (cold.is_object() && cold["label"] != "memory" && run_is_warm == floor.own.cold) return;
  record["ratio"] = record["seconds"].get<double>() / floor.own.seconds;
}

RecordFile::RecordFile(fs::path path) : path_(std::move(path)) {
  std::error_code failed;
  // Of a link itself: one that leads nowhere is refused too, or its target would be made.
  const fs::file_status status = fs::symlink_status(path_, failed);
  if (path_.empty() || !fs::exists(status)) return;
  if (!fs::is_regular_file(status))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("continue {}: it is no regular file", path_.native()));
  std::ifstream file(path_, std::ios::binary);
  std::uintmax_t whole = 0;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line) && !file.eof(); ++number) {
    auto record = nlohmann::ordered_json::parse(line, nullptr, false);
    if (!record.is_object() || record.value("format", "") != "plait-bench-1")
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("continue {}: line {} is no record of plait bench", path_.native(), number));
    records_.push_back(std::move(record));
    whole += line.size() + 1;
  }
  if (line.empty()) return;
  // An interrupted run left the beginning of a record; anything else is not ours to cut off.
  if (!line.starts_with("{\"format\":\"plait-bench-1\""))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("continue {}: its end is no record of plait bench", path_.native()));
  fs::resize_file(path_, whole);
}

void RecordFile::append(nlohmann::ordered_json record) {
  if (!path_.empty()) {
    std::ofstream file(path_, std::ios::binary | std::ios::app);
    file << record.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'
         << std::flush;
    if (!file.good()) throw Error(ErrorCode::kIo, "write " + path_.native() + ": refused");
  }
  records_.push_back(std::move(record));
}

}  // namespace plait::bench
