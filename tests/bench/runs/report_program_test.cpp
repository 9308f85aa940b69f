// plait bench report and compare as commands: exit statuses, outputs, and the page's file.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "simulated_runs.h"
#include "support/temporary_directory.h"
#include "tools/program.h"

namespace plait::test {
namespace {

TEST_CASE("report writes a table, JSON and a page, and replaces nothing unasked") {
  const TemporaryDirectory directory;
  write_lines(directory.path() / "runs.jsonl", SimulatedRuns(1).runs({{"pread"}, {"uring"}}, 5));
  const auto plait = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"bench", "report"});
    return Program(directory.path(), std::move(arguments)).wait();
  };
  const Outcome table = plait({"runs.jsonl"});
  CHECK(table.status == 0);
  CHECK(table.output.starts_with("The choice is known for "));
  CHECK_THAT(table.output, Catch::Contains("\ndisk ") && Catch::Contains("sweep-read") &&
                               Catch::Contains("uring"));
  const Outcome page = plait({"runs.jsonl", "--html", "report.html", "--json"});
  CHECK(page.status == 0);
  CHECK(page.json()["runs"] == 10);
  const std::string text = content_of(directory.path() / "report.html");
  CHECK_THAT(text, Catch::Contains("plait bench report runs.jsonl --html report.html"));
  CHECK(plait({"runs.jsonl", "--html", "report.html"}).status == 2);
  CHECK(plait({"runs.jsonl", "--html", "report.html", "--force"}).status == 0);
  CHECK(content_of(directory.path() / "report.html") == text);
  CHECK(plait({"absent.jsonl"}).status == 2);
  CHECK(plait({}).status == 2);
  std::ofstream(directory.path() / "bad.jsonl") << "no record\n";
  const Outcome bad = plait({"bad.jsonl"});
  CHECK(bad.status == 2);
  CHECK(bad.errors == "plait: read bad.jsonl:1: not JSON\n");
}

TEST_CASE("a wrong digest is exit status 1, with the page beside it") {
  const TemporaryDirectory directory;
  std::vector<nlohmann::json> records = SimulatedRuns(1).runs({{"pread"}, {"uring"}}, 5);
  records[3]["digest"]["value"] = "another";
  write_lines(directory.path() / "runs.jsonl", records);
  const Outcome outcome =
      Program(directory.path(), {"bench", "report", "runs.jsonl", "--html", "report.html"}).wait();
  CHECK(outcome.status == 1);
  CHECK(outcome.output.starts_with("FAILED"));
  CHECK_THAT(content_of(directory.path() / "report.html"),
             Catch::Contains("<body class=\"failed\">"));
}

TEST_CASE("compare is exit status 1 for a regression over the threshold") {
  const TemporaryDirectory directory;
  SimulatedRuns simulation(2);
  write_lines(directory.path() / "a.jsonl", simulation.runs({{"pread"}}, 8));
  write_lines(directory.path() / "same.jsonl", simulation.runs({{"pread"}}, 8));
  write_lines(directory.path() / "slow.jsonl",
              simulation.runs({{"pread", "sweep-read", "ext4 on vda", 1.5}}, 8));
  const auto compare = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"bench", "compare"});
    return Program(directory.path(), std::move(arguments)).wait();
  };
  const Outcome same = compare({"a.jsonl", "same.jsonl"});
  CHECK(same.status == 0);
  CHECK_THAT(same.output, Catch::Contains("No difference shown"));
  const Outcome slow = compare({"a.jsonl", "slow.jsonl", "--json"});
  CHECK(slow.status == 1);
  CHECK(slow.json()["regression"] == true);
  CHECK(slow.json()["cells"][0]["factor"]["value"] == Approx(1.25).margin(0.06));
  CHECK(compare({"a.jsonl", "slow.jsonl", "--threshold", "50%"}).status == 0);
  CHECK(compare({"slow.jsonl", "a.jsonl"}).status == 0);  // faster is no regression
  CHECK(compare({"a.jsonl", "slow.jsonl", "--threshold", "much"}).status == 2);
  CHECK(compare({"a.jsonl"}).status == 2);
}

}  // namespace
}  // namespace plait::test
