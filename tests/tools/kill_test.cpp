// Kills the program at random moments. Committed levels must stay, and the same command must
// continue.
//
// With PLAIT_LONG=1 in the environment the test kills far more often.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "support/computing.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"
#include "workplace.h"

namespace plait::test {
namespace {

int rounds(int short_run) {
  return std::getenv("PLAIT_LONG") ? 20 * short_run : unless_sanitized(short_run, 1);
}

/// Runs the program and kills it when it has computed for `lifetime_us`, unless it has ended
/// before. Returns the outcome.
Outcome run_and_kill(const std::filesystem::path& directory, const Words& arguments,
                     std::uint64_t lifetime_us) {
  Program program(directory, arguments);
  computes_for(program.process(), std::chrono::microseconds(lifetime_us));
  ::kill(program.process(), SIGKILL);
  return program.wait();
}

Words backends_on_disk() {
  Words names = usable_backends();
  std::erase(names, "memory");
  return names;
}

}  // namespace

TEST_CASE("SubdivideResume_KilledAgainAndAgain_ArrivesWithTheSameBytes") {
  std::mt19937_64 random(11);
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "2000"});
  here.succeed(
      {"subdivide", "m.ply", "whole.plait", "--levels", "5", "--normals", "--durability", "none"});
  const std::string expected = here.digest("whole.plait");
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(1); ++round) {
      const Words arguments{"subdivide", "m.ply",    "s.plait",   "--levels", "5",
                            "--normals", "--resume", "--backend", backend,    "--json",
                            "--memory",  "8MiB",     "--block",   "16KiB"};
      int level = 0;
      std::uint64_t longest_us = 100000;
      for (bool done = false; !done; longest_us += longest_us / unless_sanitized(8, 2)) {
        const Outcome outcome =
            run_and_kill(here.directory.path(), arguments, random() % longest_us);
        CAPTURE(backend, round, outcome.errors);
        REQUIRE((outcome.status == 0 || outcome.status == 1000 + SIGKILL));
        done = outcome.status == 0;
        const Outcome info = here.plait({"info", "s.plait", "--json"});
        if (info.status != 0) {
          REQUIRE(level == 0);
          continue;  // killed before its first commit
        }
        const int found = info.json()["finest_level"];
        REQUIRE(found >= level);
        level = found;
        here.succeed({"verify", "s.plait"});
      }
      CHECK(here.digest("s.plait") == expected);
      std::filesystem::remove_all(here.path("s.plait"));
    }
}

TEST_CASE("Convert_Killed_LeavesAWholeCopyOrNone") {
  std::mt19937_64 random(13);
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  here.succeed({"subdivide", "m.ply", "s.plait", "--levels", "4", "--durability", "none"});
  const std::string expected = here.digest("s.plait");
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(6); ++round) {
      const Outcome outcome = run_and_kill(
          here.directory.path(), {"convert", "s.plait", "copy.plait", "--backend", backend},
          random() % 60000);
      CAPTURE(backend, round, outcome.errors);
      const bool whole = here.has("copy.plait");
      REQUIRE((whole || outcome.status != 0));
      if (whole) CHECK(here.digest("copy.plait") == expected);
      CHECK(here.digest("s.plait") == expected);
      for (const std::string& name : here.names())
        if (name.starts_with("copy.plait")) std::filesystem::remove_all(here.path(name));
    }
}

TEST_CASE("SubdivideForce_Killed_LeavesTheOldStoreOrTheNewOne") {
  std::mt19937_64 random(19);
  const Workplace here(Medium::kMemory);
  Words digests;
  for (const char* vertices : {"800", "900"}) {
    const std::string mesh = std::string(vertices) + ".ply";
    here.succeed({"generate", "torus", mesh, "--vertices", vertices});
    REQUIRE(here.plait({"subdivide", mesh, "s.plait", "--levels", "3", "--force"}).status == 0);
    digests.push_back(here.digest("s.plait"));
  }
  REQUIRE(digests[0] != digests[1]);
  std::size_t held = 1;
  int replaced = 0, kept = 0;
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(6); ++round) {
      const std::string mesh = held == 0 ? "900.ply" : "800.ply";
      const Outcome outcome = run_and_kill(
          here.directory.path(),
          {"subdivide", mesh, "s.plait", "--levels", "3", "--force", "--backend", backend},
          random() % 60000);
      CAPTURE(backend, round, outcome.errors);
      const std::string found = here.digest("s.plait");
      const bool is_old = found == digests[held], is_new = found == digests[1 - held];
      REQUIRE((is_new || (is_old && outcome.status != 0)));
      ++(is_new ? replaced : kept);
      if (is_new) held = 1 - held;
      CHECK(here.plait({"verify", "s.plait"}).status == 0);
    }
  CHECK(replaced + kept == static_cast<int>(backends_on_disk().size()) * rounds(6));
}

}  // namespace plait::test
