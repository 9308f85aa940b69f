// Signals in the middle of long work: nothing half-made is left.
#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "program.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

/// Waits until a name that contains `part` is in the directory.
bool appears(const std::filesystem::path& directory, const std::string& part) {
  for (int attempt = 0; attempt < 3000; ++attempt) {
    for (const std::string& name : names_in(directory))
      if (name.find(part) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Signals the process once its output has begun under its temporary name.
Outcome interrupt(const std::filesystem::path& directory, Names arguments, int signal_number) {
  Program program(directory, std::move(arguments));
  CHECK(appears(directory, ".partial-"));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ::kill(program.process(), signal_number);
  return program.wait();
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

TEST_CASE("OtherCommands_Interrupted_LeaveNothing") {
  const TemporaryDirectory here;
  REQUIRE(run(here.path(), {"generate", "torus", "torus.ply", "--vertices", "8000"}).status == 0);
  REQUIRE(run(here.path(), {"subdivide", "torus.ply", "s.plait", "--levels", "5", "--no-digest",
                            "--durability", "none"})
              .status == 0);
  for (const Names& arguments : std::vector<Names>{
           {"export", "s.plait", "out.obj.zst"},
           {"convert", "s.plait", "copy.plait", "--backend", "compressed", "--codec", "zstd:19"}}) {
    CAPTURE(arguments[0]);
    CHECK(interrupt(here.path(), arguments, SIGINT).status == 128 + SIGINT);
    CHECK(names_in(here.path()) == Names{"s.plait", "torus.ply"});
  }
}

}  // namespace plait::test
