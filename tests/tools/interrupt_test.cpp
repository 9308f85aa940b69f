// Signals during long work: the program leaves no half-made file.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "program.h"
#include "support/computing.h"
#include "support/resource_limit.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

/// Whether the directory has an entry whose name contains `part`.
bool appears_now(const std::filesystem::path& directory, const std::string& part) {
  for (const std::string& name : names_in(directory))
    if (name.find(part) != std::string::npos) return true;
  return false;
}

/// Sends the signal to the program when its output exists under its temporary name.
Outcome interrupt(const std::filesystem::path& directory, const Names& arguments,
                  int signal_number) {
  return run_until(directory, arguments, signal_number,
                   [&] { return appears_now(directory, ".partial-"); });
}

}  // namespace

TEST_CASE("Subdivide_Interrupted_LeavesNothingAndSaysWhy") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "20000"}).status == 0);
  for (const std::string backend : {"pread", "mmap", "compressed"})
    for (const int signal_number : {SIGINT, SIGTERM}) {
      CAPTURE(backend, signal_number);
      const Outcome outcome = interrupt(here.path(),
                                        {"subdivide", "torus.ply", "s.plait", "--levels", "7",
                                         "--normals", "--backend", backend, "--json"},
                                        signal_number);
      CHECK(outcome.status == 128 + signal_number);
      CHECK(outcome.error_lines() == 1);
      CHECK(outcome.json()["error"]["code"] == "cancelled");
      CHECK(names_in(here.path()) == Names{"torus.ply"});
    }
}

TEST_CASE("Layout_Interrupted_LeavesNothingAndSaysWhy") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "200000"}).status == 0);
  for (const int signal_number : {SIGINT, SIGTERM}) {
    CAPTURE(signal_number);
    const Outcome outcome =
        interrupt(here.path(), {"layout", "torus.ply", "t.base", "--json"}, signal_number);
    CHECK(outcome.status == 128 + signal_number);
    CHECK(outcome.error_lines() == 1);
    CHECK(outcome.json()["error"]["code"] == "cancelled");
    CHECK(names_in(here.path()) == Names{"torus.ply"});
  }
}

TEST_CASE("Subdivide_InterruptedWhileItRounds_LeavesTheStoreThatWasThere") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "2000"}).status == 0);
  REQUIRE(run(here.path(), {"subdivide", "torus.ply", "s.plait", "--levels", "1"}).status == 0);
  const std::string before = run(here.path(), {"digest", "s.plait"}).last_line();
  // The copy that is rounded is the store's second attribute: its first file shows that it begins.
  Program program(here.path(),
                  {"subdivide", "torus.ply", "s.plait", "--levels", "5", "--force", "--max-error",
                   "1e-6rel", "--compress", "hierarchy+shuffle,zstd:19", "--json"});
  CHECK(program.runs_until([&] {
    return std::ranges::any_of(names_in(here.path()), [&](const std::string& name) {
      return name.find(".partial-") != std::string::npos &&
             appears_now(here.path() / name, "attribute1.level");
    });
  }));
  ::kill(program.process(), SIGINT);
  const Outcome outcome = program.wait();
  CHECK(outcome.status == 128 + SIGINT);
  CHECK(outcome.json()["error"]["code"] == "cancelled");
  CHECK(names_in(here.path()) == Names{"s.plait", "torus.ply"});
  CHECK(run(here.path(), {"digest", "s.plait"}).last_line() == before);
  CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
}

TEST_CASE("OtherCommands_Interrupted_LeaveNothing") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "8000"}).status == 0);
  REQUIRE(run(here.path(),
              {"subdivide", "torus.ply", "s.plait", "--levels", "5", "--durability", "none"})
              .status == 0);
  for (const Names& arguments :
       std::vector<Names>{{"export", "s.plait", "out.obj.zst"},
                          {"convert", "s.plait", "copy.plait", "--backend", "compressed",
                           "--compress", "shuffle,zstd:19"},
                          {"displace", "s.plait", "copy.plait", "--kind", "fractal"}}) {
    CAPTURE(arguments[0]);
    const Outcome outcome = interrupt(here.path(), arguments, SIGINT);
    CAPTURE(outcome.errors);
    CHECK(outcome.status == 128 + SIGINT);
    CHECK(names_in(here.path()) == Names{"s.plait", "torus.ply"});
  }
}

TEST_CASE("StepsThatHaveMadeNothingYet_Interrupted_EndAtOnce") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "400000"}).status == 0);
  const Names before = names_in(here.path());
  const std::vector<Names> all = {
      {"generate", "molecule", "m.ply", "--vertices", "3000000", "--json"},
      {"layout", "torus.ply", "--json"},
      // The base mesh is refined three times in memory, which takes many seconds.
      {"subdivide", "torus.ply", "s.plait", "--levels", "4", "--max-slot", "16", "--ignore-size",
       "--json"}};
  for (const Names& arguments : all)
    for (const int signal_number : {SIGINT, SIGTERM}) {
      CAPTURE(arguments, signal_number);
      Program program(here.path(), arguments);
      CHECK(program.runs_until_it_handles(signal_number));
      // Then it is in the step. A signal that comes before has the same outcome.
      CHECK(computes_for(program.process(), std::chrono::milliseconds(100)));
      ::kill(program.process(), signal_number);
      const Outcome outcome = program.wait();
      CHECK(outcome.status == 128 + signal_number);
      // The message is that of a run which ended at once, not after the step.
      CHECK(outcome.errors.starts_with("plait: cancelled by a signal"));
      CHECK(outcome.json()["error"]["code"] == "cancelled");
      CHECK(names_in(here.path()) == before);
    }
}

/// Runs the program with files of `bytes` bytes at most.
Outcome run_with_file_limit(const std::filesystem::path& directory, Names arguments,
                            std::uint64_t bytes) {
  const ResourceLimit limit(RLIMIT_FSIZE, bytes);
  return run(directory, std::move(arguments));
}

TEST_CASE("Files_AsLongAsTheyMayGet_AreAnErrorAndNoSignal") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "2000"}).status == 0);
  REQUIRE(run(here.path(), {"subdivide", "torus.ply", "s.plait", "--levels", "4"}).status == 0);
  REQUIRE(run(here.path(), {"generate", "torus", "big_torus.ply", "--vertices", "60000"}).status ==
          0);
  const Names before = names_in(here.path());
  const std::vector<Names> all = {
      {"generate", "torus", "big.ply", "--vertices", "100000", "--json"},
      {"export", "s.plait", "out.ply", "--json"},
      {"layout", "big_torus.ply", "t.base", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "compressed", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "mmap", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "pread", "--json"}};
  for (const Names& arguments : all) {
    const Outcome outcome = run_with_file_limit(here.path(), arguments, 1 << 20);
    CAPTURE(arguments, outcome.errors);
    CHECK(outcome.status == 1);
    CHECK(outcome.json()["error"]["message"].get<std::string>().find("File too large") !=
          std::string::npos);
    CHECK(names_in(here.path()) == before);
  }
}

}  // namespace plait::test
