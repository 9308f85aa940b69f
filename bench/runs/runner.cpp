#include "runs/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "base/stopwatch.h"
#include "compressed/codec_time.h"
#include "instrument/disk_floors.h"
#include "instrument/environment.h"
#include "instrument/scratch_directory.h"
#include "instrument/surroundings.h"
#include "plait/error.h"
#include "plait/progress.h"
#include "runs/findings.h"
#include "runs/floors.h"
#include "runs/read_runs.h"
#include "runs/record.h"
#include "runs/workloads.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;
using instrument::FloorKind;
using instrument::FloorRequest;

/// Without a number of rounds, all that is near the fastest has as many.
constexpr int kFewestRounds = 4;
/// After these, what is far behind leaves.
constexpr int kRoundsForAll = 2;
constexpr int kMostRounds = 200;
constexpr std::size_t kMostRepetitions = 30;

struct ControlledLimit {
  explicit ControlledLimit(std::uint64_t bytes) : memory(bytes), held(memory.holds()) {}
  instrument::MemoryLimit memory;
  bool held;  ///< what the control said
};

/// The member `limit` of the proofs. nullptr: the files are in memory.
nlohmann::ordered_json limit_proof(const ControlledLimit* control) {
  const bool limited = control != nullptr && control->memory.limited();
  const instrument::LimitFigures counted =
      limited ? control->memory.figures() : instrument::LimitFigures{};
  const std::string why_not =
      control == nullptr ? "the files are in memory" : control->memory.why_not();
  return {{"bytes", limited ? control->memory.bytes() : 0},
          {"version", limited ? control->memory.version() : 0},
          {"held", limited && control->held},
          {"why_not", or_null(!limited, why_not)},
          {"peak", counted.peak_bytes},
          {"times_full", counted.times_full}};
}

double disturbance_of(const nlohmann::ordered_json& record) {
  const nlohmann::ordered_json& around = record["surroundings"];
  return around.is_object() ? around["others"].get<double>() + around["stolen"].get<double>() : 0;
}

class Runner {
 public:
  Runner(const Plan& plan, const RunnerOptions& options, const BackendRegistry& backends,
         RecordFile& file)
      : plan_(plan), options_(options), backends_(backends), file_(file), floors_(options.fio) {
    for (const PlannedDisk& disk : plan.disks)
      work_.try_emplace(disk.facts.directory.native(), disk.facts.directory);
    for (const Cell& cell : plan.cells) limits_.try_emplace(cell.memory_bytes, cell.memory_bytes);
    for (const nlohmann::ordered_json& record : file.records())
      done_.insert({record["key"].get<std::string>(), record["round"].get<int>()});
  }

  RunnerResult run() {
    RunnerResult result;
    const bool is_open = options_.rounds == 0;
    for (int round = 0; round < (is_open ? kMostRounds : options_.rounds); ++round) {
      if (is_open && round >= kRoundsForAll) {
        settled_ = settled_keys(runs_of(file_.records(), "this run"));
        const auto is_settled = [&](const Cell& cell) { return settled_.contains(key_of(cell)); };
        if (std::ranges::all_of(plan_.cells, is_settled)) break;
        if (round >= kFewestRounds && is_late()) break;
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

  bool run_round(int round) {
    std::vector<std::size_t> order(plan_.cells.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
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
      nlohmann::ordered_json record = measure(cell, round, static_cast<int>(at));
      // Beside other programs the figure is theirs as well. Where the time ends a round, a round is
      // worth more than a repeat.
      if (options_.repeat_disturbed && (!options_.stops_in_round || round >= kFewestRounds) &&
          disturbance_of(record) > instrument::kDisturbed && !is_late() && proceed("")) {
        nlohmann::ordered_json again = measure(cell, round, static_cast<int>(at));
        if (again["outcome"] == "ok" && disturbance_of(again) < disturbance_of(record))
          record = std::move(again);
      }
      // A run that a signal has ended is no failed run.
      if (!proceed("")) return false;
      file_.append(std::move(record));
    }
    return true;
  }

  bool proceed(const std::string& line) const {
    return !options_.proceed || options_.proceed(line);
  }

  const instrument::DiskFacts& disk_of(const Cell& cell) const {
    for (const PlannedDisk& disk : plan_.disks)
      if (disk.facts.directory == cell.directory) return disk.facts;
    throw Error(ErrorCode::kBadState, "measure: a cell on no disk of the plan");
  }

  /// The record of a run, also of one that fails.
  nlohmann::ordered_json measure(const Cell& cell, int round, int order) {
    const instrument::DiskFacts& disk = disk_of(cell);
    const Workload& workload = workload_from_name(cell.workload);
    nlohmann::ordered_json record = empty_record(cell, round, order, options_.seed);
    record["environment"] = instrument::environment(disk);
    record["proofs"] = nlohmann::ordered_json::object();
    WorkloadRun run{cell,
                    work_.at(cell.directory.native()).path() /
                        (workload.makes_store ? "made.plait" : store_name(cell)),
                    options_.seed + static_cast<std::uint64_t>(round),
                    &backends_,
                    codec_nanoseconds(),
                    &disk,
                    {}};
    // Files in memory count as memory of the process that writes them, and there is no page cache
    // to keep small.
    const ControlledLimit* const control =
        disk.in_memory ? nullptr : &limits_.at(cell.memory_bytes);
    const instrument::MemoryLimit* const limit = control == nullptr ? nullptr : &control->memory;
    try {
      if (!workload.makes_store) prepare(run);
      measure_often(run, workload, limit, record);
      record["proofs"]["limit"] = limit_proof(control);
      measure_floor(run, workload, limit, record);
    } catch (const Error& error) {
      record["outcome"] = "failed";
      record["failure"] = error.what();
      // It may have ended in the middle of a change; what only reads has spoilt nothing.
      if (workload.changes_store || workload.makes_store) {
        prepared_.erase(run.store);
        std::error_code ignored;
        fs::remove_all(run.store, ignored);
      }
    }
    return record;
  }

  /// Until the runs together are long enough. `seconds` and `split` are means.
  void measure_often(WorkloadRun& run, const Workload& workload,
                     const instrument::MemoryLimit* limit, nlohmann::ordered_json& record) {
    const instrument::SurroundingsWatch watch;
    double seconds = 0, user_seconds = 0;
    std::vector<nlohmann::ordered_json> splits;
    do {
      Observed observed;
      const nlohmann::ordered_json result = run_once(run, workload, limit, observed);
      // One of them that a cache served makes the run warm.
      if (splits.empty() || cold_label(*run.disk, observed, result).label == "warm")
        add_result(record, result, observed, *run.disk);
      seconds += result["seconds"].get<double>();
      user_seconds += observed.process.user_seconds;
      splits.push_back(result["split"]);
    } while (seconds < options_.least_seconds && splits.size() < kMostRepetitions && proceed(""));
    const auto repetitions = static_cast<double>(splits.size());
    record["surroundings"] = to_json(watch.since(user_seconds));
    record["repetitions"] = splits.size();
    record["seconds"] = seconds / repetitions;
    for (auto& [name, part] : record["split"].items()) {
      double sum = 0;  // not known if a part is not
      for (const nlohmann::ordered_json& split : splits)
        sum += split[name].is_number() ? split[name].get<double>() : std::nan("");
      part = or_null(!std::isnan(sum), sum / repetitions);
    }
  }

  /// The work in a process of its own, cold if it reads.
  nlohmann::ordered_json run_once(WorkloadRun& run, const Workload& workload,
                                  const instrument::MemoryLimit* limit, Observed& observed) const {
    observed.reads_all = workload.reads_all;
    if (workload.makes_store) {
      fs::remove_all(run.store);
    } else {
      observed.asked_cold = true;
      observed.before = instrument::make_cold(instrument::files_under(run.store));
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

  void measure_floor(const WorkloadRun& run, const Workload& workload,
                     const instrument::MemoryLimit* limit, nlohmann::ordered_json& record) {
    const char* const needed =
        workload.floor == FloorKind::kWrite ? "needed_written" : "needed_read";
    FloorRequest request{.directory = run.store.parent_path(),
                         .kind = workload.floor,
                         .bytes = record["bytes"][needed].get<std::uint64_t>(),
                         .block_bytes = run.cell.block_bytes,
                         .direct = record["proofs"]["mode"]["direct"].get<bool>(),
                         // A store has a thread for transfers for each processor.
                         .threads = run.cell.threads + thread_count(0, "floor")};
    // Other kinds move all bytes of their file.
    if (request.kind == FloorKind::kRandomRead) request.file_bytes = run.cell.raw_bytes();
    if (request.bytes > 0) add_floor(record, request, floors_.floor(request, limit));
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
