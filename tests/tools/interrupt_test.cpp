// Signals during long work: the program leaves no half-made file.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "support/computing.h"
#include "support/resource_limit.h"
#include "workplace.h"

namespace plait::test {
namespace {

/// Whether the directory has an entry whose name contains `part`.
bool appears_now(const std::filesystem::path& directory, const std::string& part) {
  for (const std::string& name : names_in(directory))
    if (name.find(part) != std::string::npos) return true;
  return false;
}

/// Sends the signal to the program when its output exists under its temporary name.
Outcome interrupt(const std::filesystem::path& directory, const Words& arguments,
                  int signal_number) {
  return run_until(directory, arguments, signal_number,
                   [&] { return appears_now(directory, ".partial-"); });
}

}  // namespace

TEST_CASE("Subdivide_Interrupted_LeavesNothingAndSaysWhy") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "20000"});
  for (const std::string backend : {"pread", "mmap", "compressed"})
    for (const int signal_number : {SIGINT, SIGTERM}) {
      CAPTURE(backend, signal_number);
      const Outcome outcome = interrupt(here.directory.path(),
                                        {"subdivide", "torus.ply", "s.plait", "--levels", "7",
                                         "--normals", "--backend", backend, "--json"},
                                        signal_number);
      CHECK(outcome.status == 128 + signal_number);
      CHECK(outcome.error_lines() == 1);
      CHECK(outcome.json()["error"]["code"] == "cancelled");
      CHECK(here.names() == Words{"torus.ply"});
    }
}

TEST_CASE("Layout_Interrupted_LeavesNothingAndSaysWhy") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "200000"});
  for (const int signal_number : {SIGINT, SIGTERM}) {
    CAPTURE(signal_number);
    const Outcome outcome = interrupt(here.directory.path(),
                                      {"layout", "torus.ply", "t.base", "--json"}, signal_number);
    CHECK(outcome.status == 128 + signal_number);
    CHECK(outcome.error_lines() == 1);
    CHECK(outcome.json()["error"]["code"] == "cancelled");
    CHECK(here.names() == Words{"torus.ply"});
  }
}

TEST_CASE("Subdivide_InterruptedWhileItRounds_LeavesTheStoreThatWasThere") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "2000"});
  here.succeed({"subdivide", "torus.ply", "s.plait", "--levels", "1"});
  const std::string before = here.plait({"digest", "s.plait"}).last_line();
  // The copy that is rounded is the store's second attribute: its first file shows that it begins.
  Program program(here.directory.path(),
                  {"subdivide", "torus.ply", "s.plait", "--levels", "5", "--force", "--max-error",
                   "1e-6rel", "--compress", "hierarchy+shuffle,zstd:19", "--json"});
  CHECK(program.runs_until([&] {
    return std::ranges::any_of(here.names(), [&](const std::string& name) {
      return name.find(".partial-") != std::string::npos &&
             appears_now(here.path(name), "attribute1.level");
    });
  }));
  ::kill(program.process(), SIGINT);
  const Outcome outcome = program.wait();
  CHECK(outcome.status == 128 + SIGINT);
  CHECK(outcome.json()["error"]["code"] == "cancelled");
  CHECK(here.names() == Words{"s.plait", "torus.ply"});
  CHECK(here.plait({"digest", "s.plait"}).last_line() == before);
  CHECK(here.plait({"verify", "s.plait"}).status == 0);
}

TEST_CASE("OtherCommands_Interrupted_LeaveNothing") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "8000"});
  here.succeed({"subdivide", "torus.ply", "s.plait", "--levels", "5", "--durability", "none"});
  for (const Words& arguments :
       std::vector<Words>{{"export", "s.plait", "out.obj.zst"},
                          {"convert", "s.plait", "copy.plait", "--backend", "compressed",
                           "--compress", "shuffle,zstd:19"},
                          {"displace", "s.plait", "copy.plait", "--kind", "fractal"}}) {
    CAPTURE(arguments[0]);
    const Outcome outcome = interrupt(here.directory.path(), arguments, SIGINT);
    CAPTURE(outcome.errors);
    CHECK(outcome.status == 128 + SIGINT);
    CHECK(here.names() == Words{"s.plait", "torus.ply"});
  }
}

TEST_CASE("StepsThatHaveMadeNothingYet_Interrupted_EndAtOnce") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "400000"});
  const Words before = here.names();
  const std::vector<Words> all = {
      {"generate", "molecule", "m.ply", "--vertices", "3000000", "--json"},
      {"layout", "torus.ply", "--json"},
      // The base mesh is refined three times in memory, which takes many seconds.
      {"subdivide", "torus.ply", "s.plait", "--levels", "4", "--max-slot", "16", "--ignore-size",
       "--json"}};
  for (const Words& arguments : all)
    for (const int signal_number : {SIGINT, SIGTERM}) {
      CAPTURE(arguments, signal_number);
      Program program(here.directory.path(), arguments);
      CHECK(program.runs_until_it_handles(signal_number));
      // Then it is in the step. A signal that comes before has the same outcome.
      CHECK(computes_for(program.process(), std::chrono::milliseconds(100)));
      ::kill(program.process(), signal_number);
      const Outcome outcome = program.wait();
      CHECK(outcome.status == 128 + signal_number);
      // The message is that of a run which ended at once, not after the step.
      CHECK(outcome.errors.starts_with("plait: cancelled by a signal"));
      CHECK(outcome.json()["error"]["code"] == "cancelled");
      CHECK(here.names() == before);
    }
}

/// Runs the program with files of `bytes` bytes at most.
Outcome run_with_file_limit(const std::filesystem::path& directory, Words arguments,
                            std::uint64_t bytes) {
  const ResourceLimit limit(RLIMIT_FSIZE, bytes);
  return run(directory, std::move(arguments));
}

TEST_CASE("Files_AsLongAsTheyMayGet_AreAnErrorAndNoSignal") {
  const Workplace here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "2000"});
  here.succeed({"subdivide", "torus.ply", "s.plait", "--levels", "4"});
  REQUIRE(here.plait({"generate", "torus", "big_torus.ply", "--vertices", "60000"}).status == 0);
  const Words before = here.names();
  const std::vector<Words> all = {
      {"generate", "torus", "big.ply", "--vertices", "100000", "--json"},
      {"export", "s.plait", "out.ply", "--json"},
      {"layout", "big_torus.ply", "t.base", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "compressed", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "mmap", "--json"},
      {"convert", "s.plait", "copy.plait", "--backend", "pread", "--json"}};
  for (const Words& arguments : all) {
    const Outcome outcome = run_with_file_limit(here.directory.path(), arguments, 1 << 20);
    CAPTURE(arguments, outcome.errors);
    CHECK(outcome.status == 1);
    CHECK(outcome.json()["error"]["message"].get<std::string>().find("File too large") !=
          std::string::npos);
    CHECK(here.names() == before);
  }
}

}  // namespace plait::test
