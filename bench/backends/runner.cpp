#include "backends/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <utility>

#include "backends/findings.h"
#include "backends/read_runs.h"
#include "backends/record.h"
#include "backends/round_floors.h"
#include "backends/workloads.h"
#include "base/stopwatch.h"
#include "compressed/codec_time.h"
#include "instrument/disk_floors.h"
#include "instrument/environment.h"
#include "instrument/scratch_directory.h"
#include "instrument/surroundings.h"
#include "plait/error.h"
#include "plait/extend/thread_count.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;
using instrument::FloorKind;
using instrument::FloorRequest;

constexpr int kFewestRounds = 4;
constexpr int kMostRounds = 200;
constexpr int kMostRepetitions = 30;

struct ControlledLimit {
  std::unique_ptr<instrument::MemoryLimit> limit;
  bool held = false;  ///< what the control said
};

class Runner {
 public:
  Runner(const Plan& plan, const RunnerOptions& options, const BackendRegistry& backends,
         RecordFile& file)
      : plan_(plan), options_(options), backends_(backends), file_(file), floors_(options.fio) {
    for (const PlannedDisk& disk : plan.disks)
      if (!work_.contains(disk.facts.directory.native()))
        work_.emplace(disk.facts.directory.native(),
                      instrument::ScratchDirectory(disk.facts.directory));
    for (const Cell& cell : plan.cells) add_limit(cell.memory_bytes);
    for (const nlohmann::ordered_json& record : file.records())
      done_.insert({record["key"].get<std::string>(), record["round"].get<int>()});
  }

  RunnerResult run() {
    RunnerResult result;
    const bool is_open = options_.rounds == 0;
    for (int round = 0; round < (is_open ? kMostRounds : options_.rounds); ++round) {
      if (is_open && round >= kFewestRounds) {
        settled_ = settled_keys(runs_of(file_.records(), "this run"));
        const auto is_settled = [&](const Cell& cell) { return settled_.contains(key_of(cell)); };
        if (is_late() || std::ranges::all_of(plan_.cells, is_settled)) break;
      }
      floors_.begin_round(round);
      if (!run_round(round)) return result;
      result.rounds = round + 1;
    }
    result.finished = true;
    return result;
  }

 private:
  bool is_late() const { return clock_.seconds() > options_.seconds; }

  void add_limit(std::uint64_t bytes) {
    if (limits_.contains(bytes)) return;
    limits_[bytes].limit = std::make_unique<instrument::MemoryLimit>(bytes);
    limits_[bytes].held = limits_[bytes].limit->holds();
  }

  bool run_round(int round) {
    std::vector<std::size_t> order(plan_.cells.size());
    for (std::size_t at = 0; at < order.size(); ++at) order[at] = at;
    std::mt19937_64 random(options_.seed * 1000003 + static_cast<std::uint64_t>(round));
    for (std::size_t left = order.size(); left > 1; --left)
      std::swap(order[left - 1], order[random() % left]);
    for (std::size_t at = 0; at < order.size(); ++at) {
      const Cell& cell = plan_.cells[order[at]];
      if (done_.contains({key_of(cell), round}) || settled_.contains(key_of(cell))) continue;
      // The first run takes place however late it is: without a record there is nothing to report.
      if (options_.stops_in_round && is_late() && !file_.records().empty()) return false;
      if (!proceed(fmt::format("round {}, {} of {}: {} {} {}", round + 1, at + 1, order.size(),
                               cell.disk, cell.backend, cell.workload)))
        return false;
      nlohmann::ordered_json record =
          empty_record(cell, round, static_cast<int>(at), options_.seed);
      measure(cell, round, record);
      // Beside other programs the figure is theirs as well.
      if (options_.repeat_disturbed && disturbance_of(record) > instrument::kDisturbed &&
          !is_late() && proceed("")) {
        nlohmann::ordered_json again =
            empty_record(cell, round, static_cast<int>(at), options_.seed);
        measure(cell, round, again);
        if (again["outcome"] == "ok" && disturbance_of(again) < disturbance_of(record))
          record = std::move(again);
      }
      // A run that a signal has ended is no failed run.
      if (!proceed("")) return false;
      file_.append(std::move(record));
    }
    return true;
  }

  static double disturbance_of(const nlohmann::ordered_json& record) {
    const nlohmann::ordered_json& around = record["surroundings"];
    return around.is_object() ? around["others"].get<double>() + around["stolen"].get<double>() : 0;
  }

  bool proceed(const std::string& line) const {
    return !options_.proceed || options_.proceed(line);
  }

  const instrument::DiskFacts& disk_of(const Cell& cell) const {
    for (const PlannedDisk& disk : plan_.disks)
      if (disk.facts.directory == cell.directory) return disk.facts;
    throw Error(ErrorCode::kBadState, "measure: a cell on no disk of the plan");
  }

  void measure(const Cell& cell, int round, nlohmann::ordered_json& record) {
    const instrument::DiskFacts& disk = disk_of(cell);
    record["environment"] = instrument::environment(disk);
    record["proofs"] = nlohmann::ordered_json::object();
    const fs::path& work = work_.at(cell.directory.native()).path();
    WorkloadRun run{
        cell,       work / store_name(cell), options_.seed + static_cast<std::uint64_t>(round),
        &backends_, codec_nanoseconds(),     &disk,
        {}};
    try {
      const Workload& workload = workload_from_name(cell.workload);
      const instrument::MemoryLimit* const limit = limit_of(cell, disk);
      Observed observed;
      observed.reads_all = workload.reads_all;
      if (!workload.makes_store) prepare(run);
      const instrument::SurroundingsWatch watch;
      const nlohmann::ordered_json result = run_once(run, workload, limit, observed);
      add_result(record, result, observed, disk);
      double seconds = result["seconds"].get<double>();
      double user_seconds = observed.process.user_seconds;
      nlohmann::ordered_json split = result["split"];
      int repetitions = 1;
      for (; cell.rate == 0 && seconds < options_.least_seconds && repetitions < kMostRepetitions &&
             proceed("");
           ++repetitions) {
        Observed again = observed;
        const nlohmann::ordered_json more = run_once(run, workload, limit, again);
        user_seconds += again.process.user_seconds;
        // One of them that a cache served makes the run warm.
        if (cold_label(disk, again, more).label == "warm") add_result(record, more, again, disk);
        seconds += more["seconds"].get<double>();
        for (auto& [name, part] : split.items())
          if (const auto& other = more["split"][name]; part.is_number() && other.is_number())
            part = part.get<double>() + other.get<double>();
          else
            part = nullptr;
      }
      for (auto& [name, part] : split.items())
        if (part.is_number()) part = part.get<double>() / repetitions;
      record["split"] = split;
      record["surroundings"] = to_json(watch.since(user_seconds));
      record["repetitions"] = repetitions;
      record["seconds"] = seconds / repetitions;
      record["proofs"]["limit"] = limit_proof(cell, limit);
      add_floor_of(cell, workload, limit, work, result, record);
    } catch (const Error& error) {
      record["outcome"] = "failed";
      record["failure"] = error.what();
      // It may have ended in the middle of a change; what only reads has spoilt nothing.
      if (const Workload& workload = workload_from_name(cell.workload);
          workload.changes_store || workload.makes_store) {
        prepared_.erase(run.store);
        std::error_code ignored;
        fs::remove_all(run.store, ignored);
      }
    }
  }

  /// The work in a process of its own, cold if it reads.
  nlohmann::ordered_json run_once(WorkloadRun& run, const Workload& workload,
                                  const instrument::MemoryLimit* limit, Observed& observed) {
    if (workload.makes_store) {
      run.store = work_.at(run.cell.directory.native()).path() / "made.plait";
      fs::remove_all(run.store);
    } else {
      prepare(run);
      observed.asked_cold = !options_.warm;
      const std::vector<fs::path> files = instrument::files_under(run.store);
      observed.before =
          observed.asked_cold ? instrument::make_cold(files) : instrument::residency(files);
    }
    if (limit != nullptr) limit->reset_figures();
    run.codec_before_ns = codec_nanoseconds();
    run.disk_before = instrument::device_traffic(*run.disk);
    const instrument::ProcessResult got =
        instrument::run_in_own_process([&] { return nlohmann::json(workload.run(run)); }, limit);
    observed.process = got.figures;
    if (workload.makes_store) fs::remove_all(run.store);
    return got.result;
  }

  /// nullptr for files in memory: they count as memory of the process that writes them, and there
  /// is no page cache to keep small.
  const instrument::MemoryLimit* limit_of(const Cell& cell,
                                          const instrument::DiskFacts& disk) const {
    return disk.in_memory ? nullptr : limits_.at(cell.memory_bytes).limit.get();
  }

  nlohmann::ordered_json limit_proof(const Cell& cell, const instrument::MemoryLimit* limit) const {
    nlohmann::ordered_json proof = {{"bytes", 0},         {"version", 0}, {"held", false},
                                    {"why_not", nullptr}, {"peak", 0},    {"times_full", 0}};
    if (limit == nullptr || !limit->limited()) {
      proof["why_not"] = limit == nullptr ? "the files are in memory" : limit->why_not();
      return proof;
    }
    const instrument::LimitFigures counted = limit->figures();
    proof["bytes"] = limit->bytes();
    proof["version"] = limit->version();
    proof["held"] = limits_.at(cell.memory_bytes).held;
    proof["peak"] = counted.peak_bytes;
    proof["times_full"] = counted.times_full;
    return proof;
  }

  void prepare(const WorkloadRun& run) {
    if (prepared_.contains(run.store)) return;
    fs::remove_all(run.store);
    instrument::in_own_process([&]() -> nlohmann::json {
      WorkloadRun unlimited = run;
      // Making the store is not measured, and must not fail for want of memory.
      unlimited.cell.budget_bytes = std::max<std::uint64_t>(run.cell.budget_bytes, 256u << 20);
      prepare_store(unlimited);
      return true;
    });
    prepared_.insert(run.store);
  }

  void add_floor_of(const Cell& cell, const Workload& workload,
                    const instrument::MemoryLimit* limit, const fs::path& work,
                    const nlohmann::ordered_json& result, nlohmann::ordered_json& record) {
    FloorRequest request{.directory = work,
                         .kind = workload.floor,
                         .bytes = workload.floor == FloorKind::kWrite
                                      ? result["bytes"]["needed_written"].get<std::uint64_t>()
                                      : result["bytes"]["needed_read"].get<std::uint64_t>(),
                         .block_bytes = cell.block_bytes,
                         .direct = result["mode"]["direct"].get<bool>(),
                         // A store has a thread for transfers for each processor.
                         .threads = cell.threads + thread_count(0, "floor")};
    if (request.bytes == 0) return;
    // Other kinds move all bytes of their file.
    if (request.kind == FloorKind::kRandomRead) request.file_bytes = cell.raw_bytes();
    if (cell.rate > 0) return;  // an open loop waits by itself
    const RoundFloor& floor = floors_.floor(request, limit);
    add_floor(record, request, floor.own, floor.by_fio);
    record["proofs"]["second_cold"] = nullptr;
    if (floor.second_cold) record["proofs"]["second_cold"] = *floor.second_cold;
  }

  const Plan& plan_;
  const RunnerOptions& options_;
  const BackendRegistry& backends_;
  RecordFile& file_;
  Stopwatch clock_;
  std::map<std::string, instrument::ScratchDirectory> work_;
  std::map<std::uint64_t, ControlledLimit> limits_;
  std::set<std::pair<std::string, int>> done_;
  std::set<std::string> settled_;  ///< keys that need no more rounds
  std::set<fs::path> prepared_;
  RoundFloors floors_;
};

}  // namespace

RunnerResult run_cells(const Plan& plan, const RunnerOptions& options,
                       const BackendRegistry& backends, RecordFile& file) {
  return Runner(plan, options, backends, file).run();
}

}  // namespace plait::bench
