// The command on tiny surfaces. What it advises depends on the machine; what it promises does not.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "tools/program.h"

namespace plait::test {
namespace {

struct Workplace {
  TemporaryDirectory directory{Medium::kMemory};
  Workplace() { write_ply(path("mesh.ply"), random_sphere(7, 200)); }
  std::filesystem::path path(const std::string& name) const { return directory.path() / name; }
  Outcome plait(std::vector<std::string> arguments) const {
    return run(directory.path(), std::move(arguments));
  }
  void make_store() const {
    REQUIRE(plait({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--normals", "--backend",
                   "compressed", "--block", "16KiB"})
                .status == 0);
  }
};

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST_CASE("Tune_OfAStore_ReportsAndLeavesNothing") {
  const Workplace here;
  here.make_store();
  const std::string digest = here.plait({"digest", "s.plait"}).last_line();
  const Outcome outcome = here.plait({"tune", "s.plait", "--seconds", "0.2", "--json"});
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  const nlohmann::json report = outcome.json();
  for (const char* key : {"input", "goal", "seed", "attributes", "disk", "processors", "trials",
                          "choices", "other_disks", "best_at_speeds", "pick", "advice", "command"})
    CHECK(report.contains(key));
  CHECK(report["interrupted"] == false);
  CHECK(report["attributes"].size() == 2);
  CHECK(report["command"].get<std::string>().starts_with("plait convert s.plait OUT --backend "));
  CHECK(names_in(here.directory.path()) == std::vector<std::string>{"mesh.ply", "s.plait"});
  CHECK(here.plait({"digest", "s.plait"}).last_line() == digest);
}

TEST_CASE("Tune_Applied_MakesTheSameSurface_AndAPage") {
  const Workplace here;
  here.make_store();
  const Outcome outcome = here.plait({"tune", "s.plait", "--seconds", "0.2", "--goal", "size",
                                      "--html", "t.html", "--apply", "--json"});
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  const nlohmann::json applied = outcome.json()["applied"];
  CHECK(here.plait({"digest", "s-tuned.plait"}).last_line() ==
        here.plait({"digest", "s.plait"}).last_line());
  // A busy machine tries only some of the blocks in this time, so this is no more than a check that
  // both figures are of the same store. tune_test checks the figures themselves.
  CHECK(applied["found"]["stored_bytes"].get<double>() ==
        Approx(applied["predicted"]["stored_bytes"].get<double>()).epsilon(0.3));
  CHECK(applied["found"].contains("read_seconds"));
  CHECK(content(here.path("t.html")).find("<html") != std::string::npos);
  // Nothing is replaced without --force.
  CHECK(here.plait({"tune", "s.plait", "--seconds", "0.2", "--apply"}).status == 2);
  CHECK(here.plait({"tune", "s.plait", "--seconds", "0.2", "--html", "t.html"}).status == 2);
}

TEST_CASE("Tune_Exhaustive_HoldsThePickAgainstEveryCandidate") {
  const Workplace here;
  REQUIRE(here.plait({"subdivide", "mesh.ply", "s.plait", "--levels", "1", "--normals"}).status ==
          0);
  const Outcome outcome =
      here.plait({"tune", "s.plait", "--seconds", "0.2", "--exhaustive", "--json"});
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  const nlohmann::json report = outcome.json(), tried = report["exhaustive"];
  CHECK(report["reading"]["probes"].size() >= 1);
  CHECK(tried["stores"].get<int>() >= 30);
  REQUIRE(tried["finalists"].size() >= 3);
  // The best is among those that were read last, and the pick is the first of them.
  const double pick = tried["finalists"][0]["read_seconds"];
  const double best = tried["finalists"][tried["best"].get<std::size_t>()]["read_seconds"];
  for (const auto& one : tried["finalists"]) CHECK(one["read_seconds"].get<double>() >= best);
  CHECK(tried["pick_behind_best"].get<double>() == Approx(pick / best - 1));
  CHECK(names_in(here.directory.path()) == std::vector<std::string>{"mesh.ply", "s.plait"});
  CHECK(here.plait({"tune", "mesh.ply", "--exhaustive"}).status == 2);
}

TEST_CASE("Tune_OfAMesh_SaysHowFarItWasRefined") {
  const Workplace here;
  const Outcome outcome =
      here.plait({"tune", "mesh.ply", "--normals", "--seconds", "0.2", "--memory", "1MiB"});
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  CHECK(outcome.output.find("to level 3") != std::string::npos);
  CHECK(outcome.last_line().starts_with("plait subdivide mesh.ply OUT --levels 3 --normals"));
  CHECK(here.plait({"tune", "mesh.ply", "--apply"}).status == 2);
}

TEST_CASE("Tune_OfWhatCannotBeMeasured_IsRefused") {
  const Workplace here;
  here.make_store();
  CHECK(here.plait({"tune", "missing.plait"}).status == 2);
  CHECK(here.plait({"tune", "s.plait", "--goal", "speed"}).status == 2);
  CHECK(here.plait({"tune", "s.plait", "--seconds", "0"}).status == 2);
  CHECK(here.plait({"tune", "s.plait", "--dir", "nowhere", "--seconds", "0.2"}).status == 2);
  std::filesystem::create_directory(here.path("empty"));
  CHECK(here.plait({"tune", "empty"}).status != 0);
  std::ofstream(here.path("noise.ply")) << "noise";
  CHECK(here.plait({"tune", "noise.ply"}).status == 2);
  // A damaged block is named.
  for (const auto& file : std::filesystem::directory_iterator(here.path("s.plait"))) {
    if (file.path().filename().string().find("level") == std::string::npos) continue;
    std::fstream bytes(file.path(), std::ios::in | std::ios::out | std::ios::binary);
    for (int at = 0; at < 64; ++at) bytes.put('x');
  }
  const Outcome damaged = here.plait({"tune", "s.plait", "--seconds", "0.2"});
  CAPTURE(damaged.output, damaged.errors);
  CHECK(damaged.status == 1);
  CHECK(damaged.errors.find("block") != std::string::npos);
}

TEST_CASE("Tune_Interrupted_ReportsWhatThereIs") {
  const Workplace here;
  REQUIRE(here.plait({"subdivide", "mesh.ply", "s.plait", "--levels", "6", "--normals"}).status ==
          0);
  Program program(here.directory.path(), {"tune", "s.plait", "--seconds", "600", "--json"});
  // Wherever it is by now: either there is a report, or an error that says that there is none.
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  ::kill(program.process(), SIGINT);
  const Outcome outcome = program.wait();
  CHECK(outcome.status == 128 + SIGINT);
  const nlohmann::json report = outcome.json();
  if (report.contains("error"))
    CHECK(report["error"]["code"] == "cancelled");
  else
    CHECK(report["interrupted"] == true);
  CHECK(names_in(here.directory.path()) == std::vector<std::string>{"mesh.ply", "s.plait"});
}

}  // namespace plait::test
