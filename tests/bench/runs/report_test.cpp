// What `plait bench report` and `compare` say of runs whose truth is known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "instrument/figure_text.h"
#include "plait/error.h"
#include "runs/comparison.h"
#include "runs/findings.h"
#include "runs/read_runs.h"
#include "runs/report_page.h"
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

TEST_CASE("the same against itself is equal or undecided in at least 95 % of 200 reports") {
  constexpr int kReports = test::unless_sanitized(200, 20);
  int undecided = 0;
  int no_difference = 0;
  for (std::uint64_t seed = 0; seed < kReports; ++seed) {
    SimulatedRuns simulation(seed);
    const RunSet set = set_of(simulation.runs(kSame, 5));
    const Findings findings = find(set);
    REQUIRE(findings.contests.size() == 2);
    const auto has_winner = [](const Contest& contest) {
      return contest.rivals[0].answer == Answer::kSlower;
    };
    undecided += std::ranges::none_of(findings.contests, has_winner);
    const SetComparison comparison = compare(set, set_of(simulation.runs(kSame, 5)), 0.05);
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
      if (contest.choices.size() == 1) {
        ++decided;
        CHECK(findings.cells[contest.cells[0]].cell.backend == "pread");
      }
    std::vector<SimulatedRuns::Way> slower = kDifferent;
    slower[0].factor *= 1.2;
    const SetComparison comparison = compare(set, set_of(simulation.runs(slower, 8)), 0.05);
    regressions += comparison.regression;
    for (const Shift& cell : comparison.cells)
      if (cell.regression) CHECK(cell.factor.value == Approx(1.2).margin(0.06));
    CHECK(compare(set, set_of(simulation.runs(slower, 8)), 0.5).passes());
  }
  // The drift of the disk widens the intervals.
  CHECK(decided >= kPairs * 2 * 3 / 4);
  CHECK(regressions >= kPairs * 95 / 100);
}

/// Backends, workloads and disks of a full report: 5 x 3 cells of each backend.
std::vector<SimulatedRuns::Way> full_report() {
  std::vector<SimulatedRuns::Way> ways;
  for (const char* backend : {"pread", "uring", "mmap", "compressed"})
    for (const char* work : {"build", "sweep-read", "patch-random"})
      for (const char* disk : {"ext4", "xfs", "btrfs", "fast", "memory"})
        ways.push_back({backend, work, disk, 1.2});
  return ways;
}

const Shift& stratum_of(const SetComparison& comparison, const std::string& name) {
  const auto found = std::ranges::find(comparison.strata, name, &Shift::name);
  REQUIRE(found != comparison.strata.end());
  return *found;
}

TEST_CASE("a shift of 10 % in one backend's 15 cells is found, and named") {
  constexpr int kPairs = test::unless_sanitized(20, 3);
  int found = 0;
  for (std::uint64_t seed = 0; seed < kPairs; ++seed) {
    SimulatedRuns simulation(seed);
    std::vector<SimulatedRuns::Way> ways = full_report();
    const RunSet before = set_of(simulation.runs(ways, 5));
    for (SimulatedRuns::Way& way : ways)
      if (way.backend == "uring") way.factor *= 1.1;
    const SetComparison comparison = compare(before, set_of(simulation.runs(ways, 5)), 0.05);
    const Shift& uring = stratum_of(comparison, "backend uring");
    found += uring.regression && !comparison.passes();
    CHECK(uring.cells == 15);
    CHECK(uring.factor.value == Approx(1.1).margin(0.03));
    CHECK_FALSE(stratum_of(comparison, "backend mmap").regression);
    CHECK_THAT(comparison.verdict, Catch::Contains("backend uring (15 cells)"));
    CHECK_THAT(to_text(comparison), Catch::Contains("REGRESSION"));
  }
  CHECK(found == kPairs);
}

TEST_CASE("a backend that is slower in all its cells is never no regression") {
  SimulatedRuns simulation(5);
  std::vector<SimulatedRuns::Way> ways = full_report();
  const RunSet before = set_of(simulation.runs(ways, 3));
  for (SimulatedRuns::Way& way : ways)
    if (way.backend == "mmap") way.factor *= 1.3;
  const SetComparison comparison = compare(before, set_of(simulation.runs(ways, 3)), 0.05);
  CHECK_FALSE(comparison.passes());
  CHECK_THAT(comparison.verdict,
             Catch::Contains("Regression") && !Catch::Contains("No regression"));
}

TEST_CASE("what is equal is said to be, and what is not decided says how much more it takes") {
  // Three rounds and a noise of 3 %: mostly too few to tell 2 % from nothing.
  SimulatedRuns simulation(7);
  Findings few;
  for (int at = 0; at < 20 && few.contests.empty(); ++at) {
    few = find(set_of(simulation.runs({{"pread"}, {"uring"}}, 3)));
    if (few.contests[0].choices.size() == 1) few.contests.clear();
  }
  REQUIRE(few.contests.size() == 1);
  REQUIRE(few.contests[0].rivals.size() == 1);
  const Rival& open = few.contests[0].rivals[0];
  CHECK(open.answer == Answer::kUndecided);
  REQUIRE(open.more_seconds);
  CHECK(*open.more_seconds > 0);
  CHECK(std::regex_match(few.contests[0].open,
                         std::regex("which of the two: [0-9]+ more (seconds|minutes)")));
  // Two ways, of which nothing is known, are no choice that is known.
  CHECK_FALSE(few.contests[0].is_known());
  const Findings many = find(set_of(simulation.runs({{"pread"}, {"uring"}}, 40)));
  CHECK(many.contests[0].rivals[0].answer == Answer::kEqual);
  CHECK(many.contests[0].is_known());
  CHECK(many.contests[0].open.empty());
  CHECK_THAT(many.verdict, Catch::Contains("The choice is known for 1 of 1 workload."));
}

TEST_CASE("the answer is a set: two that are near, and what must not be taken") {
  // Two pipelines that change places from round to round, and a backend that takes twice the time.
  SimulatedRuns simulation(11);
  const auto simulated = [&](double factor_of_pread) {
    std::vector<json> records =
        simulation.runs({{"fast", "sweep-read", "ext4 on vda", 1},
                         {"default", "sweep-read", "ext4 on vda", 1},
                         {"pread", "sweep-read", "ext4 on vda", factor_of_pread}},
                        4);
    constexpr double kOfRound[] = {0.88, 1.12, 0.92, 1.08};
    for (json& record : records) {
      json& backend = record["cell"]["backend"];
      if (backend == "default")
        record["seconds"] =
            record["seconds"].get<double>() * kOfRound[record["round"].get<std::size_t>()];
      if (backend != "pread") record["cell"]["pipeline"] = std::exchange(backend, "compressed");
    }
    return records;
  };
  std::vector<json> records = simulated(2);
  const Findings open = find(set_of(records));
  const Contest& contest = open.contests[0];
  REQUIRE(contest.choices.size() == 2);
  CHECK(contest.is_known());
  CHECK_THAT(open.verdict,
             Catch::Contains("known for 1 of 1 workload, for 1 of them as one of two"));
  const json comparison = json(to_json(set_of(records), open))["comparisons"][0];
  CHECK(comparison["known"] == true);
  CHECK(comparison["choices"].size() == 2);
  CHECK_THAT(comparison["open"].get<std::string>(), Catch::Contains("which of the two: "));
  // Each fact stands once: what is slower stands in the row, and neither in advice nor in doubts.
  const std::string text = to_text(set_of(records), open);
  const std::string behind = text.substr(text.find("On ext4"));
  CHECK(behind.find("pread") > behind.find("ratio"));
  CHECK(settled_keys(set_of(records)).size() == 3);

  // With pipelines of one backend only, these are what is asked.
  std::erase_if(records, [](const json& record) { return record["cell"]["backend"] == "pread"; });
  CHECK_FALSE(find(set_of(records)).contests[0].is_known());
  CHECK(settled_keys(set_of(records)).empty());

  // A third that is as near leaves the choice open.
  int near = 0;
  for (int at = 0; at < 20; ++at) near += find(set_of(simulated(1))).contests[0].is_known();
  CHECK(near <= 2);
}

TEST_CASE("rounds pair: a disk that drifts by half hides no difference of a tenth") {
  std::vector<json> records;
  for (int round = 0; round < 5; ++round)
    for (const auto& [backend, seconds] : {std::pair("pread", 1.0), std::pair("uring", 1.1)})
      records.push_back(SimulatedRuns::record(
          {backend}, round, seconds * std::pow(1.5, round) * (1 + 0.001 * round), 1));
  // The same noise for both, so a hair apart.
  records[1]["seconds"] = 1.11;
  const Findings findings = find(set_of(records));
  CHECK(findings.contests[0].choices.size() == 1);
  const Rival& uring = findings.contests[0].rivals[0];
  CHECK(uring.answer == Answer::kSlower);
  CHECK(uring.factor.low < 1.1);
  CHECK(uring.factor.high > 1.1);
}

TEST_CASE("what auto would choose is held against the fastest") {
  std::vector<json> records =
      SimulatedRuns(3).runs({{"pread"}, {"uring", "sweep-read", "ext4 on vda", 2.4}}, 5);
  CHECK(text_about_auto(find(set_of(records))).empty());
  for (json& record : records) record["auto"] = record["cell"]["backend"] == "uring";
  const Findings behind = find(set_of(records));
  CHECK_THAT(behind.verdict, Catch::Contains("in 0 of 1; the farthest is") &&
                                 Catch::Contains("for sweep-read on ext4 on vda (uring)"));
  for (json& record : records) record["auto"] = record["cell"]["backend"] == "pread";
  CHECK_THAT(find(set_of(records)).verdict, Catch::Contains("does not compress in 1 of 1."));
}

TEST_CASE("a backend that dies is an outcome, and never the fastest") {
  std::vector<json> records = SimulatedRuns(3).runs(kDifferent, 5);
  for (json& record : records)
    if (record["cell"]["backend"] == "pread" && record["round"] < 3) {
      record["outcome"] = "failed";
      record["seconds"] = nullptr;
      record["failure"] = "signal 9 ended it";
    }
  const RunSet set = set_of(records);
  const Findings findings = find(set);
  for (const Contest& contest : findings.contests) {
    CHECK(findings.cells[contest.cells.front()].cell.backend == "uring");
    CHECK(contest.ranked == 1);
  }
  const std::string text = to_text(set, findings);
  CHECK_THAT(text, Catch::Contains("pread, 2 of 5"));
  CHECK_THAT(findings.verdict, Catch::Contains("2 choices must never be taken"));
  // Four cells are a table, and no plot.
  CHECK_THAT(to_page(set, findings, "c"),
             Catch::Contains("2 of 5 survived") && !Catch::Contains("<svg"));
  const RunSet full = set_of(SimulatedRuns(1).runs(full_report(), 3));
  CHECK_THAT(to_page(full, find(full), "c"), !Catch::Contains("FAILED") && Catch::Contains("<svg"));
}

TEST_CASE("auto is held against the fastest that does not compress") {
  std::vector<json> records =
      SimulatedRuns(4).runs({{"pread", "sweep-read", "ext4 on vda", 1},
                             {"uring", "sweep-read", "ext4 on vda", 1.5},
                             {"compressed", "sweep-read", "ext4 on vda", 0.5}},
                            8);
  for (json& record : records) {
    if (record["cell"]["backend"] == "compressed") record["cell"]["pipeline"] = "fast";
    record["auto"] = record["cell"]["backend"] == "uring";
  }
  std::smatch farthest;
  const std::string verdict = find(set_of(records)).verdict;
  CAPTURE(verdict);
  REQUIRE(std::regex_search(verdict, farthest, std::regex("the farthest is ([0-9.]+) times")));
  CHECK(std::stod(farthest[1]) == Approx(1.5).epsilon(0.05));
}

TEST_CASE("what is a fifth slower leaves after four rounds, and what is open stays") {
  const std::vector<SimulatedRuns::Way> ways = {{"pread"},
                                                {"uring", "sweep-read", "ext4 on vda", 1.25},
                                                {"mmap", "sweep-read", "ext4 on vda", 2.4}};
  const auto left = [&](int rounds) {
    std::set<std::string> backends;
    std::vector<json> records = SimulatedRuns(1).runs(ways, rounds);
    constexpr double kNoisy[] = {0.8, 1.2, 0.9, 1.1};
    for (json& record : records)
      if (record["cell"]["backend"] == "uring")
        record["seconds"] =
            record["seconds"].get<double>() * kNoisy[record["round"].get<std::size_t>() % 4];
    for (const std::string& key : settled_keys(set_of(records)))
      backends.insert(key.substr(0, key.find('/')));
    return backends;
  };
  CHECK(left(3).empty());
  CHECK(left(4) == std::set<std::string>{"mmap"});
  // In the end all is known well enough.
  CHECK(left(60) == std::set<std::string>{"mmap", "pread", "uring"});
}

TEST_CASE("what takes three times as long is known, and leaves, after two rounds") {
  // Twelve ways on one disk: their noise in common says what two rounds of one pair cannot.
  std::vector<SimulatedRuns::Way> ways;
  for (const char* work : {"build", "sweep-read", "patch-random"}) {
    ways.push_back({"pread", work});
    ways.push_back({"uring", work, "ext4 on vda", 1.25});
    ways.push_back({"mmap", work, "ext4 on vda", 6});
    ways.push_back({"compressed", work, "ext4 on vda", 9.6});
  }
  constexpr int kReports = test::unless_sanitized(40, 5);
  int known = 0, left = 0;
  for (std::uint64_t seed = 0; seed < kReports; ++seed) {
    const RunSet set = set_of(SimulatedRuns(seed + 500).runs(ways, 2));
    for (const Contest& contest : find(set).contests) known += contest.never.size() == 2;
    for (const std::string& key : settled_keys(set))
      left += key.starts_with("mmap") || key.starts_with("compressed");
    CHECK(settled_keys(set_of(SimulatedRuns(seed + 500).runs(ways, 1))).empty());
  }
  CHECK(known >= kReports * 3 * 9 / 10);
  CHECK(left >= kReports * 6 * 9 / 10);
}

TEST_CASE("two rounds of what is equal find no difference") {
  constexpr int kReports = test::unless_sanitized(100, 10);
  std::vector<SimulatedRuns::Way> ways = full_report();
  int wrong = 0;
  for (std::uint64_t seed = 0; seed < kReports; ++seed) {
    const Findings findings = find(set_of(SimulatedRuns(seed + 900).runs(ways, 2)));
    wrong += std::ranges::any_of(findings.contests, [](const Contest& contest) {
      return std::ranges::any_of(
          contest.rivals, [](const Rival& rival) { return rival.answer == Answer::kSlower; });
    });
  }
  CHECK(wrong <= kReports * 5 / 100);
}

TEST_CASE("the first screen fits into 100 columns, whatever the names") {
  std::vector<SimulatedRuns::Way> ways;
  for (const char* backend : {"pread", "uring", "compressed, hierarchy:along+shuffle,zstd:9",
                              "compressed, columns+shuffle,lz4"})
    for (const char* work : {"build", "sweep-read", "patch-random"})
      for (const char* disk : {"ext4 on a loop device of 200 MB/s", "xfs on nvme0n1"})
        ways.push_back({backend, work, disk, backend[0] == 'p' ? 1.2 : 5.0});
  const RunSet set = set_of(SimulatedRuns(2).runs(ways, 4));
  const std::string text = to_text(set, find(set));
  std::istringstream lines(text.substr(0, text.find("ratio")));
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    CHECK(instrument::width_of(line) <= 100);
  }
}

TEST_CASE("stopping early makes no answer of what is equal") {
  constexpr int kRuns = test::unless_sanitized(100, 10);
  int winners = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    SimulatedRuns simulation(seed + 1000);
    const std::vector<json> all = simulation.runs({{"pread"}, {"uring"}, {"mmap"}}, 30);
    std::vector<json> records;
    for (const json& record : all) {
      const bool first_of_round = record["cell"]["backend"] == "pread";
      if (first_of_round && record["round"] >= 4 && settled_keys(set_of(records)).size() == 3)
        break;
      records.push_back(record);
    }
    const Findings findings = find(set_of(records));
    for (const Rival& rival : findings.contests[0].rivals)
      winners += rival.answer == Answer::kSlower;
  }
  CHECK(winners <= kRuns * 5 / 100);
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

TEST_CASE("failures that differ in numbers and paths only are one doubt") {
  std::vector<json> records = SimulatedRuns(1).runs(kSame, 6);
  for (std::size_t at = 0; at < 5; ++at) {
    records[at]["outcome"] = "failed";
    records[at]["failure"] = at == 4 ? "signal 9 ended it"
                                     : "page in /mnt/" + std::to_string(at) + ".plait: at least " +
                                           std::to_string(at) + " bytes are needed";
  }
  const std::vector<std::string> doubts = find(set_of(records)).doubts;
  const auto failures = std::ranges::count_if(
      doubts, [](const std::string& doubt) { return doubt.starts_with("failed: "); });
  CHECK(failures == 2);
  CHECK(std::ranges::count(
            doubts, "failed: page in /mnt/0.plait: at least 0 bytes are needed (4 of 24 runs)") ==
        1);
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
  CHECK_THAT(doubts_with("/surroundings", {{"others", 0.08}, {"stolen", 0.04}}),
             Catch::Contains("other programs or machines had more than a tenth"));
  CHECK_THAT(doubts_with("/surroundings", {{"others", 0.05}, {"stolen", 0}}),
             !Catch::Contains("a tenth of the processors"));
  CHECK_THAT(doubts_with("/proofs/checksums", false), Catch::Contains("checksums"));
  CHECK_THAT(doubts_with("/doubts", json{"a doubt of its own"}),
             Catch::Contains("a doubt of its own (24 of 24 runs)"));
  CHECK_THAT(doubts_with("/ratio", nullptr), Catch::Contains("no floor"));
}

TEST_CASE("warm runs win nothing, and neither do few rounds") {
  std::vector<json> records = SimulatedRuns(2).runs(kDifferent, 6);
  REQUIRE(find(set_of(records)).contests[1].is_known());
  const auto decided = [&] {
    const Findings findings = find(set_of(records));
    return findings.contests[0].is_known() || findings.contests[1].is_known();
  };
  for (json& record : records)
    if (record["cell"]["backend"] == "pread") record["proofs"]["cold"]["label"] = "warm";
  CHECK_FALSE(decided());  // the faster one is warm, and the other one is alone
  for (json& record : records) record["proofs"]["cold"]["label"] = "warm";
  CHECK_FALSE(decided());
  CHECK(find(set_of(records)).contests[0].open == "no run was cold");
  records = SimulatedRuns(2).runs(kDifferent, 2);
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
  uneven["latencies"]["p99"] = "long";
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
  CHECK_THAT(set.skipped_lines[6],
             Catch::Contains("'p99': expected a number of at least 0, found string"));
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
  records.reserve(6);
  for (int round = 0; round < 6; ++round)
    records.push_back(SimulatedRuns::record({}, round, 3.0 + round, 2.0));
  const RunSet set = set_of(records);
  const json report = to_json(set, find(set));
  REQUIRE(report["cells"].size() == 1);
  CHECK(report["cells"][0]["seconds"]["value"].get<double>() ==
        Approx(std::pow(3. * 4 * 5 * 6 * 7 * 8, 1 / 6.)));
  CHECK(report["cells"][0]["ratio"]["value"].get<double>() ==
        Approx(report["cells"][0]["seconds"]["value"].get<double>() / 2));
  CHECK(report["cells"][0]["ratio"]["low"].get<double>() < 2.5);
  CHECK(report["cells"][0]["ratio"]["high"].get<double>() > 2.7);
  CHECK(report["runs"] == 6);
  CHECK(report["comparisons"][0]["choices"].empty());
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
  const SetComparison comparison = compare(second, set_of(broken), 0.05);
  CHECK(comparison.failed);
  CHECK_FALSE(comparison.passes());
}

}  // namespace
}  // namespace plait::bench
