#include "bench/runner.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <utility>

#include "bench/record.h"
#include "bench/workloads.h"
#include "instrument/disk_floors.h"
#include "instrument/statistics.h"
#include "plait/error.h"
#include "plait/stopwatch.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;
using instrument::FloorKind;
using instrument::FloorRequest;
using instrument::FloorResult;

constexpr int kFewestRounds = 5;
constexpr int kMostRounds = 200;
constexpr double kNarrow = 0.05;

/// A new directory on a disk, removed at the end.
class WorkDirectory {
 public:
  explicit WorkDirectory(const fs::path& parent) {
    std::string name = (parent / "plait-bench-XXXXXX").native();
    if (::mkdtemp(name.data()) == nullptr) throw system_error("create", name, errno);
    path_ = name;
  }
  ~WorkDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkDirectory(const WorkDirectory&) = delete;
  WorkDirectory& operator=(const WorkDirectory&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

struct Floor {
  FloorResult own;
  std::optional<FloorResult> by_fio;
  std::optional<double> second_cold;
};

nlohmann::json to_child_json(const FloorResult& floor) { return instrument::to_json(floor); }
FloorResult from_child_json(const nlohmann::json& json) {
  return {json["seconds"].get<double>(), json["bytes_read"].get<std::uint64_t>(),
          json["bytes_written"].get<std::uint64_t>(), json["method"].get<std::string>(),
          json["cold"].get<bool>()};
}

class Runner {
 public:
  Runner(const Plan& plan, const RunnerOptions& options, const BackendRegistry& backends,
         RecordFile& file)
      : plan_(plan), options_(options), backends_(backends), file_(file) {
    for (const PlannedDisk& disk : plan.disks)
      if (!work_.contains(disk.facts.directory.native()))
        work_.emplace(disk.facts.directory.native(),
                      std::make_unique<WorkDirectory>(disk.facts.directory));
    for (const Cell& cell : plan.cells) add_limit(cell.memory_bytes);
    for (const nlohmann::ordered_json& record : file.records())
      done_.insert({record["key"].get<std::string>(), record["round"].get<int>()});
  }

  RunnerResult run() {
    RunnerResult result;
    result.limit_doubt = limit_doubt_;
    for (int round = 0; round < kMostRounds; ++round) {
      if (options_.rounds > 0 ? round >= options_.rounds
                              : round >= kFewestRounds && (is_late() || all_are_narrow())) {
        result.finished = options_.rounds > 0 || !is_late() || round >= kFewestRounds;
        break;
      }
      floors_.clear();
      if (!run_round(round)) return result;
      result.rounds = round + 1;
    }
    return result;
  }

 private:
  bool is_late() const { return clock_.seconds() > options_.seconds; }

  void add_limit(std::uint64_t bytes) {
    if (limits_.contains(bytes)) return;
    auto limit = std::make_unique<instrument::MemoryLimit>(bytes);
    held_[bytes] = limit->holds();
    if (!held_[bytes])
      limit_doubt_ = limit->limited()
                         ? "the memory limit did not hold: the page cache may have served the runs"
                         : "no memory limit (" + limit->why_not() +
                               "): the page cache may have served the runs";
    limits_[bytes] = std::move(limit);
  }

  bool run_round(int round) {
    std::vector<std::size_t> order(plan_.cells.size());
    for (std::size_t at = 0; at < order.size(); ++at) order[at] = at;
    std::mt19937_64 random(options_.seed * 1000003 + static_cast<std::uint64_t>(round));
    for (std::size_t left = order.size(); left > 1; --left)
      std::swap(order[left - 1], order[random() % left]);
    for (std::size_t at = 0; at < order.size(); ++at) {
      const Cell& cell = plan_.cells[order[at]];
      if (done_.contains({key_of(cell), round})) continue;
      if (options_.stops_in_round && is_late()) return false;
      if (!proceed(fmt::format("round {}, {} of {}: {} {} {}", round + 1, at + 1, order.size(),
                               cell.disk, cell.backend, cell.workload)))
        return false;
      nlohmann::ordered_json record =
          empty_record(cell, round, static_cast<int>(at), options_.seed);
      measure(cell, round, record);
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

  void measure(const Cell& cell, int round, nlohmann::ordered_json& record) {
    const instrument::DiskFacts& disk = disk_of(cell);
    const instrument::MemoryLimit& limit = *limits_.at(cell.memory_bytes);
    record["environment"] = environment(disk);
    record["proofs"] = nlohmann::ordered_json::object();
    if (!held_.at(cell.memory_bytes)) record["doubts"].push_back("limit: " + limit_doubt_);
    try {
      const fs::path& work = work_.at(cell.directory.native())->path();
      const Workload& workload = workload_from_name(cell.workload);
      WorkloadRun run{cell, work / store_name(cell),
                      options_.seed + static_cast<std::uint64_t>(round), &backends_};
      Observed observed;
      observed.reads_all = workload.reads_all;
      if (workload.makes_store) {
        run.store = work / "made.plait";
        fs::remove_all(run.store);
      } else {
        prepare(run);
        observed.asked_cold = !options_.warm;
        const std::vector<fs::path> files = instrument::files_under(run.store);
        observed.before =
            observed.asked_cold ? instrument::make_cold(files) : instrument::residency(files);
      }
      limit.reset_figures();
      const instrument::DiskCounters before = instrument::disk_counters(disk);
      const instrument::ProcessResult got =
          instrument::run_in_own_process([&] { return nlohmann::json(workload.run(run)); }, &limit);
      observed.device = instrument::disk_counters(disk) - before;
      observed.process = got.figures;
      if (workload.makes_store) fs::remove_all(run.store);
      const nlohmann::ordered_json result = got.result;
      add_result(record, result, observed, disk);
      const instrument::LimitFigures counted = limit.figures();
      record["proofs"]["limit"] = {{"bytes", limit.bytes()},
                                   {"version", limit.version()},
                                   {"held", held_.at(cell.memory_bytes)},
                                   {"peak", counted.peak_bytes},
                                   {"times_full", counted.times_full}};
      add_floor_of(cell, workload, work, result, round, record);
    } catch (const Error& error) {
      record["outcome"] = "failed";
      record["failure"] = error.what();
    }
  }

  void prepare(const WorkloadRun& run) {
    const bool has_bounds = run.cell.workload == "box";
    if (prepared_.contains(run.store) && (!has_bounds || bounded_.contains(run.store))) return;
    fs::remove_all(run.store);
    instrument::in_own_process([&]() -> nlohmann::json {
      WorkloadRun unlimited = run;
      // Making the store is not measured, and must not fail for want of memory.
      unlimited.cell.budget_bytes = std::max<std::uint64_t>(run.cell.budget_bytes, 256u << 20);
      prepare_store(unlimited);
      return true;
    });
    prepared_.insert(run.store);
    if (has_bounds) bounded_.insert(run.store);
  }

  void add_floor_of(const Cell& cell, const Workload& workload, const fs::path& work,
                    const nlohmann::ordered_json& result, int round,
                    nlohmann::ordered_json& record) {
    FloorRequest request{.directory = work,
                         .kind = workload.floor,
                         .bytes = workload.floor == FloorKind::kWrite
                                      ? result["needed_written"].get<std::uint64_t>()
                                      : result["needed_read"].get<std::uint64_t>(),
                         .block_bytes = cell.block_bytes,
                         .direct = result["mode"]["direct"].get<bool>(),
                         .durable = true,
                         .threads = cell.threads + 1};  // a store has a thread for transfers
    if (request.bytes == 0) return;
    // Other kinds move all bytes of their file.
    if (request.kind == FloorKind::kRandomRead) request.file_bytes = cell.raw_bytes();
    const std::string key =
        fmt::format("{} {} {} {} {} {}", work.native(), instrument::to_string(request.kind),
                    request.bytes, request.block_bytes, request.direct, cell.memory_bytes);
    if (cell.rate > 0) return;  // an open loop waits by itself
    auto at = floors_.find(key);
    if (at == floors_.end())
      at = floors_.emplace(key, measure_floor(request, cell, round == 0)).first;
    add_floor(record, request, at->second.own, at->second.by_fio);
    record["proofs"]["second_cold"] = nullptr;
    if (const std::optional<double>& second = at->second.second_cold) {
      record["proofs"]["second_cold"] = *second;
      if (*second > 1.3)
        record["doubts"].push_back(
            fmt::format("cache below: a second cold read was {:.1f} times as fast", *second));
    }
  }

  Floor measure_floor(const FloorRequest& request, const Cell& cell, bool first_round) {
    const instrument::MemoryLimit* const limit = limits_.at(cell.memory_bytes).get();
    if (request.kind != FloorKind::kWrite)
      instrument::in_own_process([&]() -> nlohmann::json {
        const fs::path file = request.directory / "plait-bench.floor";
        const std::uint64_t bytes = std::max(request.bytes, request.file_bytes);
        if (!fs::exists(file) || fs::file_size(file) < bytes) prepare_floor_file(request);
        return true;
      });
    const auto once = [&] {
      return from_child_json(
          instrument::run_in_own_process([&] { return to_child_json(own_floor(request)); }, limit)
              .result);
    };
    Floor floor{once(), {}, {}};
    if (!first_round) return floor;
    if (request.kind == FloorKind::kRead) floor.second_cold = floor.own.seconds / once().seconds;
    if (options_.fio && instrument::have_fio()) {
      const nlohmann::json by_fio =
          instrument::run_in_own_process(
              [&]() -> nlohmann::json {
                const auto result = fio_floor(request);
                return result ? to_child_json(*result) : nlohmann::json(nullptr);
              },
              limit)
              .result;
      if (by_fio.is_object()) floor.by_fio = from_child_json(by_fio);
    }
    return floor;
  }

  /// Whether each cell's interval of the median ratio is narrow enough; cells without a ratio are.
  bool all_are_narrow() const {
    std::map<std::string, std::vector<double>> ratios;
    for (const nlohmann::ordered_json& record : file_.records())
      if (record["ratio"].is_number())
        ratios[record["key"].get<std::string>()].push_back(record["ratio"].get<double>());
    return std::ranges::all_of(plan_.cells, [&](const Cell& cell) {
      const auto at = ratios.find(key_of(cell));
      return at == ratios.end() ||
             instrument::median_interval(at->second).relative_half_width() < kNarrow;
    });
  }

  const Plan& plan_;
  const RunnerOptions& options_;
  const BackendRegistry& backends_;
  RecordFile& file_;
  Stopwatch clock_;
  std::map<std::string, std::unique_ptr<WorkDirectory>> work_;
  std::map<std::uint64_t, std::unique_ptr<instrument::MemoryLimit>> limits_;
  std::map<std::uint64_t, bool> held_;
  std::string limit_doubt_;
  std::set<std::pair<std::string, int>> done_;
  std::set<fs::path> prepared_, bounded_;
  std::map<std::string, Floor> floors_;
};

}  // namespace

RunnerResult run_cells(const Plan& plan, const RunnerOptions& options,
                       const BackendRegistry& backends, RecordFile& file) {
  return Runner(plan, options, backends, file).run();
}

}  // namespace plait::bench
