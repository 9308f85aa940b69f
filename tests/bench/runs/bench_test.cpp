// The instrument is tested: backends of known speed are reported as that, a warm run is labelled
// warm, wrong data fail everything, and an interrupted file goes on.
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <set>

#include "instrument/memory_limit.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"
#include "instrument/surroundings.h"
#include "plait/error.h"
#include "plait/extend/plugins.h"
#include "runs/findings.h"
#include "runs/measured_store.h"
#include "runs/plan.h"
#include "runs/read_runs.h"
#include "runs/record.h"
#include "runs/runner.h"
#include "support/sanitized.h"
#include "support/skip.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using namespace plait::bench;
using Json = nlohmann::ordered_json;

struct Bench {
  Bench() { plugins.load(PLAIT_SLOW_BACKEND); }

  std::vector<Json> run(PlanRequest request, RunnerOptions options,
                        const fs::path& out = {}) const {
    request.disks = {{directory.path()}};
    if (options.rounds == 0) options.rounds = 1;
    options.fio = false;
    options.repeat_disturbed = false;  // tests compare a run with what its backend counted
    options.least_seconds = std::min(options.least_seconds, least_seconds);
    RecordFile file(out);
    run_cells(make_plan(request, plugins.backends()), options, plugins.backends(), file);
    return file.records();
  }
  /// What the slow backends say of the last process that used them.
  struct Served {
    double slept = 0, span = 0, bytes = 0;
  };
  Served served() const {
    Served truth;
    std::ifstream(directory.path() / "served") >> truth.slept >> truth.span >> truth.bytes;
    return truth;
  }

  double least_seconds = 0;  ///< what the slow backends count is of one process
  TemporaryDirectory directory;
  Plugins plugins;
};

/// An environment variable for the time of a test.
struct Variable {
  Variable(const char* variable, const std::string& value) : name(variable) {
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() { ::unsetenv(name); }
  const char* name;
};

PlanRequest small(const std::string& backend, const std::string& workload) {
  PlanRequest request;
  request.backends = {backend};
  request.workloads = {workload};
  request.vertices = 2000;
  request.levels = 3;
  request.blocks = {64u << 10};
  return request;
}

Findings findings_of(const std::vector<Json>& records) { return find(runs_of(records, "runs")); }

/// Processes that compute, for the time of a test.
class BusyProcesses {
 public:
  explicit BusyProcesses(int count) {
    for (int at = 0; at < count; ++at)
      if (children_.push_back(::fork()); children_.back() == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (volatile std::uint64_t number = 0;;) number = number + 1;
      }
  }
  ~BusyProcesses() {
    for (const pid_t child : children_) {
      ::kill(child, SIGKILL);
      ::waitpid(child, nullptr, 0);
    }
  }

 private:
  std::vector<pid_t> children_;
};

/// What comes before the first read of a run and after its last one is in the run's time and not in
/// the backend's account. It takes milliseconds of a run of seconds, but a busy machine may stop
/// the process there: so a few tries, and nothing is said if other programs were busy in all of
/// them.
constexpr int kTries = 4;
/// A sanitizer makes our own work many times as long, and so does not belong to the disk's.
constexpr double kPart = unless_sanitized(0.05, 0.5);

/// Repeats the run until its time is at most 5 % more than the backend's own account; `check` holds
/// for each.
template <class Check>
void hold_against_truth(const Bench& bench, const PlanRequest& request, int busy, Check check) {
  const Variable variable("PLAIT_TEST_SERVED", (bench.directory.path() / "served").native());
  const BusyProcesses processes(busy);
  double seconds = 0, span = 0, others = 0;
  for (int at = 0; at < kTries; ++at) {
    const Json record = bench.run(request, {}).at(0);
    INFO(record.dump());
    REQUIRE(record["outcome"] == "ok");
    const Bench::Served truth = bench.served();
    seconds = record["seconds"].get<double>();
    span = truth.span;
    others = record["surroundings"]["others"].get<double>();
    CHECK(seconds >= 0.95 * span);
    CHECK(record["split"]["wait"].get<double>() > 0);
    check(record, truth);
    if (seconds <= (1 + kPart) * span) return;
  }
  if (others > instrument::kDisturbed) return skip("other programs had the processors");
  CHECK(seconds <= (1 + kPart) * span);
}

}  // namespace

TEST_CASE("a delay of 50 ms a read is reported as that, to 5 % either way, also beside others") {
  Bench bench;
  const Variable delay("PLAIT_TEST_DELAY", "50");
  for (const int busy : {0, 3})
    hold_against_truth(bench, small("x-late", "patch-random"), busy,
                       [](const Json& record, const Bench::Served& truth) {
                         const double blocks = record["bytes"]["blocks_read"].get<double>();
                         REQUIRE(blocks > 5);
                         CHECK(truth.slept >= 0.05 * blocks);
                         // One caller waits for all that the backend sleeps.
                         const double wait = record["split"]["wait"].get<double>();
                         CHECK(wait >= 0.95 * truth.slept);
                         CHECK(wait <= record["seconds"].get<double>());
                         CHECK(record["latencies"]["max"].get<double>() >= 0.05);
                         CHECK(record["split"]["codec"].is_null());
                       });
}

TEST_CASE("a cap of 20 MB/s is reported as that, to 5 % either way, also beside others") {
  Bench bench;
  const Variable cap("PLAIT_TEST_CAP", "20");
  PlanRequest request = small("x-capped", "sweep-read");
  request.vertices = 3200;
  request.levels = 5;  // few base vertices, so that opening the store takes no time
  for (const int busy : {0, 3})
    hold_against_truth(bench, request, busy, [](const Json& record, const Bench::Served& truth) {
      CHECK(truth.bytes == record["bytes"]["moved_read"].get<double>());
      CHECK(truth.bytes / truth.span <= 21e6);
      CHECK(record["bytes"]["needed_read"].get<double>() <= truth.bytes);
    });
}

TEST_CASE("a short run does its work again, each time as cold as before") {
  Bench bench;
  bench.least_seconds = 0.3;
  const Json record = bench.run(small("x-late", "patch-random"), {}).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  const double repetitions = record["repetitions"].get<double>();
  CHECK(repetitions * record["seconds"].get<double>() >= 0.3);
  CHECK((repetitions - 1) * 0.005 * record["bytes"]["blocks_read"].get<double>() < 0.3);
  // The figures are of one time.
  CHECK(record["split"]["wait"].get<double>() <= record["seconds"].get<double>());
  bench.least_seconds = 0;
  CHECK(bench.run(small("x-late", "patch-random"), {}).at(0)["repetitions"] == 1);
}

TEST_CASE("what the digest reads after the time is no traffic of the run") {
  if (std::ranges::count(usable_backends(), "uring") == 0) return skip("io_uring is not usable");
  Bench bench;
  PlanRequest request = small("uring", "build");
  request.vertices = 3200;
  request.levels = 5;
  const Json record = bench.run(request, {}).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  if (record["bytes"]["process_read"].is_null()) return skip("the kernel counts nothing");
  const double written = record["bytes"]["stored"].get<double>();
  CHECK(record["bytes"]["process_read"].get<double>() <= written / 4);
}

TEST_CASE("cold needs both proofs") {
  instrument::DiskFacts disk;
  Observed observed;
  observed.reads_all = observed.asked_cold = true;
  observed.before = {1000, 0};
  Json result = {{"bytes", {{"process_read", 1000}, {"stored", 1000}, {"moved_read", 1000}}}};
  CHECK(cold_label(disk, observed, result).label == "cold");
  result["bytes"]["process_read"] = 400;  // a cache below the page cache, or pages that came back
  CHECK(cold_label(disk, observed, result).label == "warm");
  result["bytes"]["process_read"] = nullptr;
  CHECK(cold_label(disk, observed, result).label == "warm");
  result["bytes"]["process_read"] = 1000;
  observed.before.resident_bytes = 20;
  CHECK(cold_label(disk, observed, result).label == "warm");
  observed.before.resident_bytes = 0;
  observed.asked_cold = false;
  CHECK(cold_label(disk, observed, result).label == "warm");
  disk.in_memory = true;
  CHECK(cold_label(disk, observed, result).label == "memory");
}

TEST_CASE("wrong data of one backend fail everything") {
  Bench bench;
  PlanRequest request = small("pread", "sweep-read");
  request.backends = {"pread", "mmap"};
  std::vector<Json> records = bench.run(request, {});
  REQUIRE(records.size() == 2);
  CHECK_FALSE(findings_of(records).failed);
  // The checksum finds what x-wrong turns after reading only if the store compares it.
  request.backends = {"x-wrong"};
  records.push_back(bench.run(request, {}).at(0));
  if (records.back()["outcome"] == "ok") {
    CHECK(findings_of(records).verdict.starts_with("FAILED"));
  } else {
    CHECK(records.back()["failure"].is_string());
  }
  records.resize(2);
  records[1]["digest"]["value"] = "0000000000000000";
  CHECK(findings_of(records).verdict.starts_with("FAILED"));
  for (Json& record : records) record["digest"]["value"] = "torn";
  CHECK(findings_of(records).spoiling >= 2);
}

TEST_CASE("a run that was killed in the middle of a change spoils no later run") {
  Bench bench;
  const Variable variable("PLAIT_TEST_KILLED", "3");
  PlanRequest request = small("x-killed", "sweep-update");
  request.workloads = {"sweep-update", "sweep-read"};
  RunnerOptions options;
  options.rounds = 4;
  int failed = 0;
  for (const Json& record : bench.run(request, options)) {
    INFO(record.dump());
    if (record["cell"]["workload"] == "sweep-update") {
      CHECK_THAT(record["failure"].get<std::string>(), Catch::Contains("signal 9"));
      ++failed;
    } else {
      CHECK(record["outcome"] == "ok");
    }
  }
  CHECK(failed == 4);
}

TEST_CASE("an interrupted file goes on") {
  Bench bench;
  const fs::path out = bench.directory.path() / "runs.jsonl";
  PlanRequest request = small("pread", "sweep-read");
  request.workloads = {"sweep-read", "build", "sweep-update", "patch-random", "scan-export"};
  RunnerOptions options;
  int runs = 0;
  options.proceed = [&](const std::string& line) { return line.empty() || ++runs <= 2; };
  CHECK(bench.run(request, options, out).size() == 2);
  std::ofstream(out, std::ios::app) << "{\"format\":\"plait-bench-1\",\"key";
  options.proceed = {};
  const std::vector<Json> records = bench.run(request, options, out);
  CHECK(records.size() == 5);
  std::set<std::string> keys;
  for (const Json& record : records) {
    INFO(record.dump());
    CHECK(record["outcome"] == "ok");
    keys.insert(record["key"].get<std::string>());
  }
  CHECK(keys.size() == 5);
  CHECK(bench.run(request, options, out).size() == 5);
  std::ofstream(out, std::ios::app) << "something else\n";
  CHECK_THROWS_AS(RecordFile(out), Error);
}

TEST_CASE("a file of records that is a link to nothing is refused, and nothing is made") {
  const TemporaryDirectory here;
  fs::create_symlink(here.path() / "absent", here.path() / "runs.jsonl");
  CHECK_THROWS_AS(RecordFile(here.path() / "runs.jsonl"), Error);
  CHECK_FALSE(fs::exists(here.path() / "absent"));
}

TEST_CASE("a time that is up before the first run still measures that run") {
  Bench bench;
  PlanRequest request = small("pread", "build");
  request.workloads = {"build", "sweep-read"};
  RunnerOptions options;
  options.seconds = 0;
  options.stops_in_round = true;
  CHECK(bench.run(request, options).size() == 1);
}

TEST_CASE("workloads that write give the data that those that read expect") {
  Bench bench;
  PlanRequest request = small("pread", "build");
  request.backends = {"pread", "compressed"};
  request.workloads = {"build", "sweep-read", "sweep-update"};
  const std::vector<Json> records = bench.run(request, {});
  // With the preset `default`, no record can be changed in place.
  CHECK(records.size() == 8);
  for (const Json& record : records) {
    INFO(record.dump());
    CHECK(record["outcome"] == "ok");
    if (record["cell"]["pipeline"] == "fast")
      CHECK(record["split"]["codec"].get<double>() > 0);
    else
      CHECK(record["split"]["codec"].is_number() == (record["cell"]["backend"] == "compressed"));
  }
  CHECK_FALSE(findings_of(records).failed);
  for (const fs::directory_entry& left : fs::directory_iterator(bench.directory.path()))
    FAIL_CHECK("left behind: " << left.path());
}

TEST_CASE("a plan refuses to fill a disk, and makes nothing") {
  Bench bench;
  PlanRequest request = small("pread", "sweep-read");
  request.disks = {{bench.directory.path()}};
  Plan plan = make_plan(request, bench.plugins.backends());
  CHECK(refusals(plan, 0).empty());
  CHECK(refusals(plan, 1).size() == 1);
  plan.disks[0].facts.bytes = 100 * plan.disks[0].needed_bytes;
  plan.disks[0].facts.free_bytes = 11 * plan.disks[0].needed_bytes;
  CHECK(refusals(plan, 0).empty());
  plan.disks[0].facts.free_bytes = 11 * plan.disks[0].needed_bytes - 1;
  CHECK(refusals(plan, 0).size() == 1);
  CHECK(fs::is_empty(bench.directory.path()));
  request.workloads = {"sweep"};
  CHECK_THROWS_AS(make_plan(request, bench.plugins.backends()), Error);
}

TEST_CASE("a small memory gets small blocks") {
  const Bench bench;
  PlanRequest request = small("x-capped", "build");
  request.blocks.clear();
  request.memory = {1u << 20, 256u << 20};
  const Plan plan = make_plan(request, bench.plugins.backends());
  REQUIRE(plan.cells.size() == 2);
  CHECK(plan.cells[0].block_bytes == 16u << 10);
  CHECK(plan.cells[1].block_bytes == 64u << 10);
}

TEST_CASE("a key names the measurement and not the place") {
  Bench bench;
  const TemporaryDirectory elsewhere;
  const auto keys_of = [&](std::vector<DiskPlace> disks) {
    PlanRequest request = small("pread", "build");
    request.disks = std::move(disks);
    std::vector<std::string> keys;
    for (const Cell& cell : make_plan(request, bench.plugins.backends()).cells)
      keys.push_back(key_of(cell));
    return keys;
  };
  const fs::path here = bench.directory.path();
  CHECK(keys_of({{here, "nvme"}}) == keys_of({{elsewhere.path(), "nvme"}}));
  // Two directories of one disk are two places.
  const std::vector<std::string> both = keys_of({{here}, {elsewhere.path()}});
  REQUIRE(both.size() == 2);
  CHECK(both[0] != both[1]);
}

TEST_CASE("auto is a backend with a reason, and no cell is there twice") {
  Bench bench;
  PlanRequest request = small("auto", "build");
  request.backends = {"auto", "pread", "uring"};
  request.disks = {{bench.directory.path()}};
  const Plan plan = make_plan(request, bench.plugins.backends());
  REQUIRE(plan.chosen.size() == 1);
  CHECK(plan.cells.size() == 2);
  for (const Cell& cell : plan.cells) CHECK(cell.backend != "auto");
  CHECK_THAT(plan.chosen[0],
             Catch::Contains(plan.cells[0].backend) && Catch::Contains("compared with the memory"));
  CHECK_THAT(to_text(plan), Catch::Contains(plan.chosen[0]));
}

TEST_CASE("quantiles of latencies are order statistics") {
  std::vector<double> seconds;
  for (int at = 1; at <= 1000; ++at) seconds.push_back(1e-3 * at);
  const Json latencies = latencies_to_json(seconds);
  CHECK(latencies["p50"] == 0.5);
  CHECK(latencies["p99"] == 0.99);
  CHECK(latencies["max"] == 1.0);
  CHECK(latencies["count"] == 1000);
  CHECK(latencies_to_json({}).is_null());
}

TEST_CASE("a memory limit holds, or says why there is none") {
  const instrument::MemoryLimit limit(32u << 20);
  if (limit.limited())
    CHECK(limit.holds());
  else
    CHECK_FALSE(limit.why_not().empty());
  TemporaryDirectory empty;
  const instrument::MemoryLimit none(32u << 20, {.v1 = empty.path() / "absent", .v2 = {}});
  CHECK_FALSE(none.limited());
  CHECK_FALSE(none.holds());
}

TEST_CASE("an error of a process keeps its code and message") {
  try {
    instrument::in_own_process(
        []() -> nlohmann::json { throw Error(ErrorCode::kBudget, "too small"); });
    FAIL("no error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBudget);
    CHECK(std::string(error.what()) == "too small");
  }
  CHECK_THROWS_AS(instrument::in_own_process([]() -> nlohmann::json { ::_exit(3); }), Error);
}

TEST_CASE("QuickMemory_SlowDisks_MovesLess") {
  constexpr DiskSpeed kFast{2e9, 2e9}, kMedium{2e8, 2e8}, kSlow{5e7, 5e7};
  constexpr double kTwoMinutes = 110;
  const auto memory = [](std::vector<DiskSpeed> disks, double seconds) {
    return quick_memory(disks, seconds) >> 20;
  };
  CHECK(memory({kFast}, kTwoMinutes) == 64);
  CHECK(memory({kFast, kFast}, kTwoMinutes) == 64);
  CHECK(memory({kFast, kMedium}, kTwoMinutes) == 32);
  CHECK(memory({kFast, kMedium}, 2 * kTwoMinutes) == 64);
  CHECK(memory({kFast, kSlow}, kTwoMinutes) == 16);
  CHECK(memory({kSlow, kSlow}, 1) == 16);
}

TEST_CASE("QuickMemory_SpeedsOfADirectory_AreMeasuredAndNothingStays") {
  const TemporaryDirectory directory;
  const std::vector<fs::path> twice = {directory.path(), directory.path()};
  const std::vector<DiskSpeed> speeds = measure_speeds(twice);
  REQUIRE(speeds.size() == 2);
  for (const DiskSpeed& speed : speeds) {
    CHECK(speed.write > 0);
    CHECK(speed.read > 0);
  }
  CHECK(fs::is_empty(directory.path()));
  const std::vector<fs::path> absent = {directory.path() / "absent"};
  CHECK_THROWS_AS(measure_speeds(absent), Error);
}

}  // namespace plait::test
