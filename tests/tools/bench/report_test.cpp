// What `plait bench report` and `compare` say of runs whose truth is known.
#include <catch2/catch.hpp>
#include <regex>

#include "bench/comparison.h"
#include "bench/findings.h"
#include "bench/findings_page.h"
#include "bench/read_runs.h"
#include "plait/error.h"
#include "simulated_runs.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"

namespace plait::bench {
namespace {

using nlohmann::json;
using test::SimulatedRuns;

RunSet set_of(const std::vector<json>& records, const std::string& more = "") {
  const test::TemporaryDirectory directory;
  test::write_lines(directory.path() / "runs.jsonl", records, more);
  return read_runs({directory.path() / "runs.jsonl"});
}

const std::vector<SimulatedRuns::Way> kSame = {
    {"pread"}, {"uring"}, {"pread", "build"}, {"uring", "build"}};
const std::vector<SimulatedRuns::Way> kDifferent = {{"pread"},
                                                    {"uring", "sweep-read", "ext4 on vda", 2.0},
                                                    {"pread", "build"},
                                                    {"uring", "build", "ext4 on vda", 2.4}};

TEST_CASE("the same against itself is undecided in at least 95 % of 200 reports") {
  constexpr int kReports = test::unless_sanitized(200, 20);
  int undecided = 0;
  int no_difference = 0;
  for (std::uint64_t seed = 0; seed < kReports; ++seed) {
    SimulatedRuns simulation(seed);
    const RunSet set = set_of(simulation.runs(kSame, 5));
    const Findings findings = find(set);
    REQUIRE(findings.contests.size() == 2);
    undecided += !findings.contests[0].decided && !findings.contests[1].decided;
    const Comparison comparison = compare(set, set_of(simulation.runs(kSame, 5)), 0.05);
    no_difference += comparison.verdict.starts_with("No difference shown") && comparison.passes();
  }
  CHECK(undecided >= kReports * 95 / 100);
  CHECK(no_difference >= kReports * 95 / 100);
}

TEST_CASE("a real difference is found") {
  constexpr int kPairs = test::unless_sanitized(40, 10);
  int decided = 0;
  int regressions = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    SimulatedRuns simulation(seed);
    const RunSet set = set_of(simulation.runs(kDifferent, 8));
    const Findings findings = find(set);
    for (const Contest& contest : findings.contests)
      if (contest.decided) {
        ++decided;
        CHECK(findings.cells[contest.cells[0]].cell.backend == "pread");
      }
    std::vector<SimulatedRuns::Way> slower = kDifferent;
    slower[0].factor *= 1.2;
    const Comparison comparison = compare(set, set_of(simulation.runs(slower, 8)), 0.05);
    regressions += comparison.regression;
    for (const ComparedCell& cell : comparison.cells)
      if (cell.regression) CHECK(cell.factor.value == Approx(1.2).margin(0.06));
    CHECK(compare(set, set_of(simulation.runs(slower, 8)), 0.5).passes());
  }
  // The drift of the disk widens the intervals.
  CHECK(decided >= kPairs * 2 * 3 / 4);
  CHECK(regressions >= kPairs * 95 / 100);
}

TEST_CASE("one cell among many cannot be shown with five rounds, and the doubts say so") {
  std::vector<SimulatedRuns::Way> ways;
  for (int at = 0; at < 20; ++at)
    ways.push_back({"pread", "sweep-read", "ext4 on vda", 1.2, 1.0 + at});
  SimulatedRuns simulation(1);
  const Comparison comparison =
      compare(set_of(simulation.runs(ways, 5)), set_of(simulation.runs(ways, 5)), 0.05);
  CHECK(comparison.doubts.size() == 1);
  CHECK(comparison.doubts[0].starts_with("20 of 20 cells have too few rounds"));
}

TEST_CASE("a wrong digest fails the set and turns the page red") {
  std::vector<json> records = SimulatedRuns(1).runs(kSame, 5);
  CHECK_FALSE(find(set_of(records)).failed);
  records[7]["digest"]["value"] = "fedcba9876543210";
  const RunSet set = set_of(records);
  const Findings findings = find(set);
  CHECK(findings.failed);
  CHECK(findings.verdict.starts_with("FAILED"));
  CHECK(findings.doubts[0].find("fedcba9876543210") != std::string::npos);
  CHECK(to_page(set, findings, "c").find("<body class=\"failed\">") != std::string::npos);
  CHECK(to_text(set, findings).starts_with("FAILED"));
  CHECK(to_json(set, findings)["failed"] == true);
  // So does a digest that differs between the two sides of a comparison.
  const RunSet right = set_of(SimulatedRuns(1).runs(kSame, 5));
  CHECK_FALSE(compare(right, set, 10).passes());
}

TEST_CASE("what limits the trust in a run is a doubt") {
  const auto doubts_with = [](const std::string& pointer, const json& value) {
    std::vector<json> records = SimulatedRuns(1).runs(kSame, 6);
    for (json& record : records) record[json::json_pointer(pointer)] = value;
    std::string all;
    for (const std::string& doubt : find(set_of(records)).doubts) all += doubt + "\n";
    return all;
  };
  CHECK_THAT(doubts_with("/round", 0), !Catch::Contains("limit") && !Catch::Contains("warm"));
  CHECK_THAT(doubts_with("/proofs/limit/held", false), Catch::Contains("limit was not held"));
  CHECK_THAT(doubts_with("/proofs/limit/bytes", 0), Catch::Contains("no memory limit"));
  CHECK_THAT(doubts_with("/proofs/limit", {{"bytes", 0}, {"why_not", "not permitted"}}),
             Catch::Contains("no memory limit (not permitted)"));
  // Files in memory need none.
  json in_memory = SimulatedRuns(1).runs({{}}, 1)[0];
  in_memory["proofs"]["limit"]["bytes"] = 0;
  in_memory["environment"]["disk"]["in_memory"] = true;
  CHECK_THAT(doubts_with("", in_memory), !Catch::Contains("memory limit"));
  CHECK_THAT(doubts_with("/proofs/cold/label", "warm"), Catch::Contains("warm"));
  CHECK_THAT(doubts_with("/proofs/second_cold", 3), Catch::Contains("cache below this machine"));
  CHECK_THAT(doubts_with("/floor_by_fio/seconds", 30), Catch::Contains("differ by more than 10 %"));
  CHECK_THAT(doubts_with("/proofs/others/device_written", 1e9), Catch::Contains("other programs"));
  CHECK_THAT(doubts_with("/proofs/checksums", false), Catch::Contains("checksums"));
  CHECK_THAT(doubts_with("/doubts", json{"a doubt of its own"}),
             Catch::Contains("a doubt of its own (24 of 24 runs)"));
  CHECK_THAT(doubts_with("/ratio", nullptr), Catch::Contains("no floor"));
}

TEST_CASE("warm runs win nothing, and neither do few rounds") {
  std::vector<json> records = SimulatedRuns(2).runs(kDifferent, 6);
  REQUIRE(find(set_of(records)).contests[1].decided);
  const auto decided = [&] {
    const Findings findings = find(set_of(records));
    return findings.contests[0].decided || findings.contests[1].decided;
  };
  for (json& record : records)
    if (record["cell"]["backend"] == "pread") record["proofs"]["cold"]["label"] = "warm";
  CHECK_FALSE(decided());  // the faster one is warm, and the other one is alone
  for (json& record : records) record["proofs"]["cold"]["label"] = "warm";
  CHECK_FALSE(decided());
  CHECK(find(set_of(records)).contests[0].why_not == "no run was cold");
  records = SimulatedRuns(2).runs(kDifferent, 4);
  CHECK_FALSE(decided());
}

TEST_CASE("lines that are no records are skipped and counted") {
  const std::vector<json> good = SimulatedRuns(3).runs(kSame, 5);
  const std::string huge(kMostLineBytes + 10, 'x');
  json wrong_type = good[0];
  wrong_type["seconds"] = "fast";
  json negative = good[0];
  negative["seconds"] = -1;
  json other_format = good[0];
  other_format["format"] = "plait-bench-9";
  json uneven = good[0];
  uneven["latencies"]["histogram"]["counts"] = {1};
  std::string not_a_number = good[0].dump();
  not_a_number.replace(not_a_number.find("\"peak_rss\":"), 11, "\"peak_rss\":NaN,\"x\":");
  std::string too_large = good[0].dump();
  too_large.replace(too_large.find("\"peak_rss\":"), 11, "\"peak_rss\":1e999,\"x\":");
  const std::string deep(200'000, '[');
  const std::string lines = "{\"format\"\n" + huge + "\n[]\n" + wrong_type.dump() + "\n" +
                            negative.dump() + "\n" + other_format.dump() + "\n" + uneven.dump() +
                            "\n" + not_a_number + "\n" + too_large + "\n" + deep + "\n\n" +
                            std::string("\0\xff\n", 3) + good[0].dump();  // without a newline
  const RunSet set = set_of(good, lines);
  CHECK(set.runs.size() == good.size());
  CHECK(set.skipped == 12);
  REQUIRE(set.skipped_lines.size() == 10);
  CHECK_THAT(set.skipped_lines[0], Catch::Contains("runs.jsonl:21: not JSON"));
  CHECK_THAT(set.skipped_lines[1], Catch::Contains(":22: expected at most 1048576 bytes"));
  CHECK_THAT(set.skipped_lines[3],
             Catch::Contains(":24: 'seconds': expected a number of at least 0, found string"));
  CHECK_THAT(set.skipped_lines[5],
             Catch::Contains("expected the format plait-bench-1, found 'plait-bench-9'"));
  CHECK_THAT(set.skipped_lines[6], Catch::Contains("one edge more"));
  // If nothing is left, the first line says why.
  try {
    set_of({}, "nonsense\n");
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK_THAT(error.what(), Catch::Contains("runs.jsonl:1: not JSON"));
  }
  CHECK_THROWS_AS(read_runs({"/does/not/exist.jsonl"}), Error);
}

TEST_CASE("values of every wrong type are refused, never believed") {
  const json good = SimulatedRuns(4).runs({{}}, 1)[0];
  std::size_t tried = 0;
  const json places = good.flatten();
  for (const auto& [pointer, value] : places.items())
    for (const json& wrong : {json("text"), json(-1.5), json::array({1, "x"}),
                              json::object({{"a", 1}}), json(true), json(nullptr)}) {
      json record = good;
      record[json::json_pointer(pointer)] = wrong;
      const RunSet set = set_of({good, record});
      CHECK(set.runs.size() + set.skipped == 2);
      to_page(set, find(set), "c");
      ++tried;
    }
  CHECK(tried > 300);
}

TEST_CASE("digests, ratios and intervals of the report are those of the records") {
  std::vector<json> records;
  for (int round = 0; round < 6; ++round)
    records.push_back(SimulatedRuns::record({}, round, 3.0 + round, 2.0));
  const RunSet set = set_of(records);
  const json report = to_json(set, find(set));
  REQUIRE(report["cells"].size() == 1);
  CHECK(report["cells"][0]["seconds"]["median"] == 5.5);
  CHECK(report["cells"][0]["ratio"]["median"] == 2.75);
  CHECK(report["cells"][0]["ratio"]["low"] == 1.5);
  CHECK(report["cells"][0]["ratio"]["high"] == 4.0);
  CHECK(report["runs"] == 6);
  CHECK(report["comparisons"][0]["fastest"].is_null());
}

TEST_CASE("cells that are not in both sets are named, and nothing in common is refused") {
  SimulatedRuns simulation(5);
  const RunSet first = set_of(simulation.runs({{"pread"}, {"mmap"}}, 5));
  const RunSet second = set_of(simulation.runs({{"pread"}}, 5));
  CHECK(compare(first, second, 0.05).doubts[0] == "1 cells are in one of the two only");
  CHECK_THROWS_AS(compare(second, set_of(simulation.runs({{"uring"}}, 5)), 0.05), Error);
  // What worked before and fails now fails the comparison.
  std::vector<json> broken = simulation.runs({{"pread"}}, 5);
  broken[2]["outcome"] = "failed";
  broken[2]["seconds"] = nullptr;
  const Comparison comparison = compare(second, set_of(broken), 0.05);
  CHECK(comparison.failed);
  CHECK_FALSE(comparison.passes());
}

}  // namespace
}  // namespace plait::bench
