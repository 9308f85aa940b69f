// plait bench run and --quick as commands: what they print, and what they leave after a signal.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>
#include <thread>

#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "tools/program.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Words = std::vector<std::string>;

std::size_t lines_of(const fs::path& path) {
  const std::string text = content_of(path);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Small, but with room to spare: the system kills a run that needs more, and that is a failed run.
/// Without a sanitizer 40 MiB are enough; under the address sanitizer a build needs more than 64.
const std::string kMemory = unless_sanitized("64MiB", "128MiB");

/// The address sanitizer keeps up to 256 MiB of what was freed, unless it is told.
void keep_little_of_what_was_freed() {
  const char* const options = std::getenv("ASAN_OPTIONS");
  ::setenv("ASAN_OPTIONS",
           ((options ? options : "") + std::string(":quarantine_size_mb=1")).c_str(), 1);
}

Words quick(Words more) {
  keep_little_of_what_was_freed();
  Words words = {"bench",     "--quick",  ".",        "--memory",        kMemory,
                 "--backend", "x-capped", "--plugin", PLAIT_SLOW_BACKEND};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Waits for the first record. If the program ends before, or hangs, says what it said.
void wait_for_record(Program& program, const fs::path& records) {
  if (program.runs_until([&] { return lines_of(records) > 0; })) return;
  ::kill(program.process(), SIGKILL);
  const Outcome outcome = program.wait();
  FAIL("no record; status " << outcome.status << ": " << outcome.output << outcome.errors);
}

}  // namespace

TEST_CASE("--quick prints a table and a verdict, and writes page and records") {
  const TemporaryDirectory here;
  const Outcome outcome = run(here.path(), quick({"--time", "1s", "--json"}));
  INFO(outcome.errors << outcome.output);
  REQUIRE(outcome.status == 0);
  const json report = outcome.json();
  CHECK(report["html"] == "report.html");
  CHECK(report["failed"] == false);
  REQUIRE_FALSE(report["records"].empty());
  CHECK(report["runs"] == report["records"].size());
  CHECK_FALSE(report["verdict"].get<std::string>().empty());
  CHECK(report["records"][0]["cell"]["backend"] == "x-capped");
  CHECK(lines_of(here.path() / "report.jsonl") == report["records"].size());
  CHECK_THAT(content_of(here.path() / "report.html"), Catch::Contains("x-capped"));
  CHECK(names_in(here.path()) == Words{"report.html", "report.jsonl"});

  // The page and the records are somebody's now.
  CHECK(run(here.path(), quick({"--time", "1s"})).status == 2);
  fs::remove(here.path() / "report.html");
  const Outcome records = run(here.path(), quick({"--time", "1s"}));
  CHECK(records.status == 2);
  CHECK_THAT(records.errors, Catch::Contains("report.jsonl"));
}

TEST_CASE("--quick measures the user's mesh, as fine as the memory asks for") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "open-sheet", "sheet.ply", "--vertices",
                            unless_sanitized("1200", "2400")})
              .status == 0);
  const Outcome outcome =
      run(here.path(), quick({"--mesh", "sheet.ply", "--time", "1s", "--json"}));
  INFO(outcome.errors << outcome.output);
  REQUIRE(outcome.status == 0);
  const json report = outcome.json();
  REQUIRE_FALSE(report["records"].empty());
  const json cell = report["records"][0]["cell"];
  CHECK(cell["mesh"].get<std::string>().starts_with("sheet.ply "));
  CHECK(cell["levels"] == 6);
  CHECK(cell["ratio"].get<double>() <= 3);
  CHECK(cell["ratio"].get<double>() > 0.7);
  CHECK(run(here.path(), quick({"--mesh", "absent.ply", "--force"})).status == 2);
}

TEST_CASE("--quick ended by Ctrl-C keeps the records, and writes page and verdict of them") {
  const TemporaryDirectory here;
  Program program(here.path(), quick({}));
  const fs::path records = here.path() / "report.jsonl";
  wait_for_record(program, records);
  ::kill(program.process(), SIGINT);
  const Outcome outcome = program.wait();
  INFO(outcome.errors);
  CHECK(outcome.status == 128 + SIGINT);
  CHECK(outcome.error_lines() == 1);
  CHECK_THAT(outcome.output,
             Catch::Contains("x-capped") && Catch::Contains("report.html: the page"));
  CHECK(lines_of(records) > 0);
  CHECK_THAT(content_of(here.path() / "report.html"), Catch::Contains("<h1>plait bench</h1>"));
  CHECK(names_in(here.path()) == Words{"report.html", "report.jsonl"});
  // What was kept can be reported.
  CHECK(run(here.path(), {"bench", "report", "report.jsonl"}).status == 0);
}

TEST_CASE("what a killed --quick leaves, clean removes") {
  const TemporaryDirectory here;
  Program program(here.path(), quick({}));
  const fs::path records = here.path() / "report.jsonl";
  wait_for_record(program, records);
  const json busy = run(here.path(), {"clean", ".", "--json"}).json();
  CHECK(busy["left_over"][0]["in_use"] == true);
  ::kill(program.process(), SIGKILL);
  CHECK(program.wait().status != 0);
  CHECK(names_in(here.path()).size() == 2);
  // The measured process ends with its parent, but not in the same instant.
  for (int at = 0; at < 3000 && names_in(here.path()).size() == 2; ++at) {
    CHECK(run(here.path(), {"clean", "."}).status == 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  CHECK(names_in(here.path()) == Words{"report.jsonl"});
}

TEST_CASE("run measures levels over the user's mesh") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "open-sheet", "sheet.ply", "--vertices", "400"}).status ==
          0);
  const Outcome outcome =
      run(here.path(), {"bench", "run", "--mesh", "sheet.ply", "--levels", "3", "--backend",
                        "pread,compressed", "--workload", "build,sweep-read", "--rounds", "1",
                        "--memory", kMemory, "--no-fio", "--json", "--dir", "named=."});
  INFO(outcome.errors << outcome.output);
  REQUIRE(outcome.status == 0);
  const json report = outcome.json();
  REQUIRE(report["records"].size() == 6);  // compressed with fast and with default
  // Another command makes the same surface.
  const json made = run(here.path(), {"subdivide", "sheet.ply", "--levels", "3", "--backend",
                                      "memory", "--digest", "--json"})
                        .json();
  CHECK(report["failed"] == false);
  for (const json& record : report["records"]) {
    INFO(record.dump());
    CHECK(record["outcome"] == "ok");
    const json& cell = record["cell"];
    CHECK(cell["disk"] == "named");
    CHECK(
        std::regex_match(cell["mesh"].get<std::string>(), std::regex("sheet\\.ply [0-9a-f]{16}")));
    CHECK(record["digest"]["of"].get<std::string>().find("sheet.ply") != std::string::npos);
    if (cell["workload"] == "build") CHECK(record["digest"]["value"] == made["digest"]);
    CHECK(cell["vertices"] == made["vertices"]);
    CHECK(record["split"]["codec"].is_number() == (cell["backend"] == "compressed"));
    const json& commit = record["environment"]["commit"];
    if (!commit.is_null())
      CHECK(std::regex_match(commit.get<std::string>(), std::regex("[0-9a-f]{40}(-dirty)?")));
  }
  CHECK_THAT(report["comparisons"][0]["size"].get<std::string>(), Catch::Contains("sheet.ply"));
  CHECK(run(here.path(), {"bench", "run", "--mesh", "absent.ply", "--dry-run"}).status == 2);
  CHECK(run(here.path(), {"bench", "run", "--mesh", "sheet.ply", "--vertices", "100"}).status == 2);
}

}  // namespace plait::test
