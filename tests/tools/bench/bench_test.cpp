// The instrument is tested: backends of known speed are reported as that, a warm run is labelled
// warm, wrong data fail everything, and an interrupted file goes on.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <set>

#include "bench/latencies.h"
#include "bench/plan.h"
#include "bench/record.h"
#include "bench/record_file.h"
#include "bench/run_table.h"
#include "bench/runner.h"
#include "instrument/memory_limit.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"
#include "plait/backends/plugins.h"
#include "plait/error.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using namespace plait::bench;
using Json = nlohmann::ordered_json;

struct Bench {
  Bench() { plugins.load(PLAIT_SLOW_BACKEND); }

  std::vector<Json> run(PlanRequest request, RunnerOptions options, const fs::path& out = {}) {
    request.directories = {directory.path()};
    request.levels = 3;
    request.memory = {128u << 20};
    if (options.rounds == 0) options.rounds = 1;
    options.fio = false;
    RecordFile file(out);
    run_cells(make_plan(request, plugins.backends()), options, plugins.backends(), file);
    return file.records();
  }
  double slept() const {
    double seconds = 0;
    std::ifstream(directory.path() / "slept") >> seconds;
    return seconds;
  }

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
  request.blocks = {64u << 10};
  return request;
}

}  // namespace

TEST_CASE("a delay of 5 ms a read is in the time, to 5 %") {
  Bench bench;
  const Variable variable("PLAIT_TEST_SLEPT", (bench.directory.path() / "slept").native());
  const Json record = bench.run(small("x-late", "patch-random"), {}).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  const double blocks = record["bytes"]["blocks_read"].get<double>();
  REQUIRE(blocks > 5);
  CHECK(bench.slept() >= 0.005 * blocks);
  // The backend says how long it really slept, because a busy machine wakes it late. More than that
  // is the machine's time, which no test may bound.
  CHECK(record["seconds"].get<double>() >= bench.slept() * 0.95);
  CHECK(record["split"]["wait"].get<double>() >= bench.slept() * 0.95);
  CHECK(record["latencies"]["max"].get<double>() >= 0.005);
}

TEST_CASE("a cap of 200 MB/s is never reported as more, to 5 %") {
  Bench bench;
  const Variable variable("PLAIT_TEST_SLEPT", (bench.directory.path() / "slept").native());
  PlanRequest request = small("x-capped", "sweep-read");
  request.vertices = 50000;
  const Json record = bench.run(request, {}).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  const double rate =
      record["bytes"]["needed_read"].get<double>() / record["seconds"].get<double>();
  CHECK(rate <= 210e6);
  CHECK(record["split"]["wait"].get<double>() > 0);
}

TEST_CASE("a stall of 2 s shows in the p99 of an open loop") {
  Bench bench;
  const Variable variable("PLAIT_TEST_STALL", "2000");
  PlanRequest request = small("x-late", "patch-random");
  request.rate = 100;
  const Json record = bench.run(request, {}).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  // 200 of 300 requests were due during the stall: a closed loop would show one slow request.
  CHECK(record["latencies"]["p99"].get<double>() > 1.8);
  CHECK(record["latencies"]["p50"].get<double>() > 0.3);
  CHECK(record["open_loop"]["from"] == "scheduled");
}

TEST_CASE("a warm run is labelled warm and has no ratio to a cold floor") {
  Bench bench;
  RunnerOptions options;
  options.warm = true;
  const Json record = bench.run(small("pread", "sweep-read"), options).at(0);
  INFO(record.dump());
  REQUIRE(record["outcome"] == "ok");
  const std::string label = record["proofs"]["cold"]["label"].get<std::string>();
  CHECK((label == "warm" || label == "memory"));
}

TEST_CASE("cold needs both proofs") {
  instrument::DiskFacts disk;
  Observed observed;
  observed.reads_all = observed.asked_cold = true;
  observed.before = {1000, 0};
  Json result = {{"process_read", 1000}, {"stored", 1000}, {"moved_read", 1000}};
  CHECK(cold_label(disk, observed, result).label == "cold");
  result["process_read"] = 400;  // a cache below the page cache, or pages that came back
  CHECK(cold_label(disk, observed, result).label == "warm");
  result["process_read"] = nullptr;
  CHECK(cold_label(disk, observed, result).label == "warm");
  result["process_read"] = 1000;
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
  CHECK(different_digests(records).empty());
  CHECK_FALSE(verdict(records).starts_with("FAILED"));
  // The checksum finds what x-wrong turns after reading only if the store compares it.
  request.backends = {"x-wrong"};
  records.push_back(bench.run(request, {}).at(0));
  if (records.back()["outcome"] == "ok") {
    CHECK_FALSE(different_digests(records).empty());
    CHECK(verdict(records).starts_with("FAILED"));
  } else {
    CHECK(records.back()["failure"].is_string());
  }
  records.resize(2);
  records[1]["digest"]["value"] = "0000000000000000";
  CHECK(different_digests(records).size() == 1);
  CHECK(verdict(records).starts_with("FAILED"));
}

TEST_CASE("an interrupted file goes on") {
  Bench bench;
  const fs::path out = bench.directory.path() / "runs.jsonl";
  PlanRequest request = small("pread", "sweep-read");
  request.workloads = {"sweep-read", "coarse", "open", "box", "scan-export"};
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

TEST_CASE("workloads that write give the data that those that read expect") {
  Bench bench;
  PlanRequest request = small("pread", "build");
  request.backends = {"pread", "compressed"};
  request.workloads = {"build", "passes", "sweep-update", "sweep-update-journal", "mixed"};
  const std::vector<Json> records = bench.run(request, {});
  CHECK(records.size() == 10);
  for (const Json& record : records) {
    INFO(record.dump());
    CHECK(record["outcome"] == "ok");
  }
  CHECK(different_digests(records).empty());
  for (const fs::directory_entry& left : fs::directory_iterator(bench.directory.path()))
    FAIL_CHECK("left behind: " << left.path());
}

TEST_CASE("a plan refuses to fill a disk, and makes nothing") {
  Bench bench;
  PlanRequest request = small("pread", "sweep-read");
  request.directories = {bench.directory.path()};
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

TEST_CASE("quantiles are order statistics, and every latency is in a bin") {
  std::vector<double> seconds;
  for (int at = 1; at <= 1000; ++at) seconds.push_back(1e-3 * at);
  const Json latencies = latencies_to_json(seconds);
  CHECK(latencies["p50"] == 0.5);
  CHECK(latencies["p99"] == 0.99);
  CHECK(latencies["max"] == 1.0);
  std::uint64_t all = 0;
  for (const Json& count : latencies["histogram"]["counts"]) all += count.get<std::uint64_t>();
  CHECK(all == 1000);
  CHECK(latencies["histogram"]["edges"].size() == latencies["histogram"]["counts"].size() + 1);
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

}  // namespace plait::test
