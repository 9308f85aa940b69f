// Kills the program at random moments. Committed levels must stay, and the same command must
// continue.
//
// With PLAIT_LONG=1 in the environment the test kills far more often.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "program.h"
#include "support/computing.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

int rounds(int short_run) {
  return std::getenv("PLAIT_LONG") ? 20 * short_run : unless_sanitized(short_run, 1);
}

/// Runs the program and kills it when it has computed for `lifetime_us`, unless it has ended
/// before. Returns the outcome.
Outcome run_and_kill(const std::filesystem::path& directory, const Names& arguments,
                     std::uint64_t lifetime_us) {
  Program program(directory, arguments);
  computes_for(program.process(), std::chrono::microseconds(lifetime_us));
  ::kill(program.process(), SIGKILL);
  return program.wait();
}

std::string digest_of(const std::filesystem::path& directory, const std::string& store) {
  const Outcome outcome = run(directory, {"digest", store, "--json"});
  REQUIRE(outcome.status == 0);
  return outcome.json()["digest"];
}

void flip_every_third_block(const std::filesystem::path& file, std::uint64_t block_bytes) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  const std::uint64_t bytes = std::filesystem::file_size(file);
  for (std::uint64_t at = 5; at < bytes; at += 3 * block_bytes) {
    stream.seekg(static_cast<std::streamoff>(at));
    const char byte = static_cast<char>(stream.get());
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(static_cast<char>(byte ^ 0x20));
  }
  REQUIRE(stream.good());
}

std::vector<std::string> backends_on_disk() {
  std::vector<std::string> names = usable_backends();
  std::erase(names, "memory");
  return names;
}

}  // namespace

TEST_CASE("SubdivideResume_KilledAgainAndAgain_ArrivesWithTheSameBytes") {
  std::mt19937_64 random(11);
  const TemporaryDirectory here(Medium::kMemory);
  REQUIRE(run(here.path(), {"generate", "torus", "m.ply", "--vertices", "2000"}).status == 0);
  REQUIRE(run(here.path(), {"subdivide", "m.ply", "whole.plait", "--levels", "5", "--normals",
                            "--durability", "none"})
              .status == 0);
  const std::string expected = digest_of(here.path(), "whole.plait");
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(1); ++round) {
      const Names arguments{"subdivide", "m.ply",    "s.plait",   "--levels", "5",
                            "--normals", "--resume", "--backend", backend,    "--json",
                            "--memory",  "8MiB",     "--block",   "16KiB"};
      int level = 0;
      std::uint64_t longest_us = 100000;
      for (bool done = false; !done; longest_us += longest_us / unless_sanitized(8, 2)) {
        const Outcome outcome = run_and_kill(here.path(), arguments, random() % longest_us);
        CAPTURE(backend, round, outcome.errors);
        REQUIRE((outcome.status == 0 || outcome.status == 1000 + SIGKILL));
        done = outcome.status == 0;
        const Outcome info = run(here.path(), {"info", "s.plait", "--json"});
        if (info.status != 0) {
          REQUIRE(level == 0);
          continue;  // killed before its first commit
        }
        const int found = info.json()["finest_level"];
        REQUIRE(found >= level);
        level = found;
        REQUIRE(run(here.path(), {"verify", "s.plait"}).status == 0);
      }
      CHECK(digest_of(here.path(), "s.plait") == expected);
      std::filesystem::remove_all(here.path() / "s.plait");
    }
}

TEST_CASE("Convert_Killed_LeavesAWholeCopyOrNone") {
  std::mt19937_64 random(13);
  const TemporaryDirectory here(Medium::kMemory);
  REQUIRE(run(here.path(), {"generate", "torus", "m.ply", "--vertices", "500"}).status == 0);
  REQUIRE(
      run(here.path(), {"subdivide", "m.ply", "s.plait", "--levels", "4", "--durability", "none"})
          .status == 0);
  const std::string expected = digest_of(here.path(), "s.plait");
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(6); ++round) {
      const Outcome outcome =
          run_and_kill(here.path(), {"convert", "s.plait", "copy.plait", "--backend", backend},
                       random() % 60000);
      CAPTURE(backend, round, outcome.errors);
      const bool whole = std::filesystem::exists(here.path() / "copy.plait");
      REQUIRE((whole || outcome.status != 0));
      if (whole) CHECK(digest_of(here.path(), "copy.plait") == expected);
      CHECK(digest_of(here.path(), "s.plait") == expected);
      for (const std::string& name : names_in(here.path()))
        if (name.starts_with("copy.plait")) std::filesystem::remove_all(here.path() / name);
    }
}

TEST_CASE("Repair_KilledAgainAndAgain_EndsWithTheStoreAsItWas") {
  std::mt19937_64 random(17);
  for (const std::string backend : {"pread", "compressed"})
    for (int round = 0; round < rounds(2); ++round) {
      const TemporaryDirectory here(Medium::kMemory);
      REQUIRE(run(here.path(), {"generate", "torus", "m.ply", "--vertices", "2000"}).status == 0);
      REQUIRE(run(here.path(), {"subdivide", "m.ply", "s.plait", "--levels", "4", "--normals",
                                "--backend", backend, "--block", "16KiB"})
                  .status == 0);
      const std::string expected = digest_of(here.path(), "s.plait");
      flip_every_third_block(here.path() / "s.plait" / "attribute0.level04.1", 16 << 10);
      flip_every_third_block(here.path() / "s.plait" / "attribute1.level02.1", 16 << 10);
      REQUIRE(run(here.path(), {"verify", "s.plait"}).status == 1);
      std::uint64_t longest_us = 20000;
      for (bool done = false; !done; longest_us += longest_us / 4) {
        const Outcome outcome =
            run_and_kill(here.path(), {"repair", "s.plait", "--json"}, random() % longest_us);
        CAPTURE(backend, round, outcome.errors);
        REQUIRE((outcome.status == 0 || outcome.status == 1000 + SIGKILL));
        done = outcome.status == 0;
        REQUIRE(run(here.path(), {"info", "s.plait"}).status == 0);
      }
      CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
      CHECK(digest_of(here.path(), "s.plait") == expected);
    }
}

TEST_CASE("SubdivideForce_Killed_LeavesTheOldStoreOrTheNewOne") {
  std::mt19937_64 random(19);
  const TemporaryDirectory here(Medium::kMemory);
  std::vector<std::string> digests;
  for (const char* vertices : {"800", "900"}) {
    const std::string mesh = std::string(vertices) + ".ply";
    REQUIRE(run(here.path(), {"generate", "torus", mesh, "--vertices", vertices}).status == 0);
    REQUIRE(run(here.path(), {"subdivide", mesh, "s.plait", "--levels", "3", "--force"}).status ==
            0);
    digests.push_back(digest_of(here.path(), "s.plait"));
  }
  REQUIRE(digests[0] != digests[1]);
  std::size_t held = 1;
  int replaced = 0, kept = 0;
  for (const std::string& backend : backends_on_disk())
    for (int round = 0; round < rounds(6); ++round) {
      const std::string mesh = held == 0 ? "900.ply" : "800.ply";
      const Outcome outcome = run_and_kill(
          here.path(),
          {"subdivide", mesh, "s.plait", "--levels", "3", "--force", "--backend", backend},
          random() % 60000);
      CAPTURE(backend, round, outcome.errors);
      const std::string found = digest_of(here.path(), "s.plait");
      const bool is_old = found == digests[held], is_new = found == digests[1 - held];
      REQUIRE((is_new || (is_old && outcome.status != 0)));
      ++(is_new ? replaced : kept);
      if (is_new) held = 1 - held;
      CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
    }
  CHECK(replaced + kept == static_cast<int>(backends_on_disk().size()) * rounds(6));
}

}  // namespace plait::test
