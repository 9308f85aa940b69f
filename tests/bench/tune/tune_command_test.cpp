// The command on tiny surfaces. What it advises depends on the machine; what it promises does not.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "support/computing.h"
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
  for (const char* key : {"input", "goal", "doubts", "sample", "choices", "other_disks_by_formula",
                          "pick", "advice", "command", "environment"})
    CHECK(report.contains(key));
  CHECK(report["interrupted"] == false);
  CHECK(report["choices"].size() <= 6);
  // Of raw blocks, the backend is measured that auto takes here.
  const std::string raw = default_backends().choose({.path = here.directory.path()}).name;
  for (const auto& [preset, options] :
       std::vector<std::pair<std::string, std::string>>{{"none", "--backend " + raw},
                                                        {"fast", "--compress fast"},
                                                        {"default", "--compress default"},
                                                        {"small", "--compress small"}})
    CHECK(std::ranges::any_of(report["choices"], [&](const auto& choice) {
      return choice["name"] == preset && choice["options"] == options;
    }));
  CHECK(report["command"].get<std::string>().starts_with("plait convert s.plait OUT --"));
  CHECK(names_in(here.directory.path()) == std::vector<std::string>{"mesh.ply", "s.plait"});
  CHECK(here.plait({"digest", "s.plait"}).last_line() == digest);
}

TEST_CASE("Tune_OfAScansStore_OffersAQuarterOfItsDistanceAsABound_UnlessItIsRounded") {
  const Workplace here;
  write_ply(here.path("scan.ply"), random_sphere(7, 2000));
  const auto offers = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"remesh", "scan.ply", "s.plait", "--faces",
                                          "100",    "--force",  "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome made = here.plait(arguments);
    REQUIRE(made.status == 0);
    const nlohmann::json report = made.json();
    const Outcome outcome = here.plait({"tune", "s.plait", "--seconds", "0.1", "--json"});
    REQUIRE(outcome.status == 0);
    const std::string doubts = outcome.json()["doubts"].dump();
    constexpr std::string_view kOption = "--max-error ";
    const std::size_t at = doubts.find(kOption);
    if (at == std::string::npos) return false;
    const double rms = std::max(report["scan_to_store"]["rms"].get<double>(),
                                report["store_to_scan"]["rms"].get<double>());
    CHECK(std::stod(doubts.substr(at + kOption.size())) == Approx(rms / 4).epsilon(0.06));
    return true;
  };
  CHECK(offers({}));
  CHECK_FALSE(offers({"--max-error", "1e-5rel"}));
  CHECK_FALSE(offers({"--samples", "0"}));
}

TEST_CASE("Tune_WithoutTimeForARound_AdvisesOfThePresets_AndSaysSo") {
  const Workplace here;
  here.make_store();
  const Outcome outcome = here.plait({"tune", "s.plait", "--seconds", "0.1", "--json"});
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  const nlohmann::json report = outcome.json();
  CHECK(std::ranges::any_of(report["doubts"], [](const std::string& doubt) {
    return doubt.find("the time was up before 4 rounds") != std::string::npos;
  }));
  for (const auto& choice : report["choices"])
    if (choice["pick"] == true) CHECK(choice["rounds"] >= 1);
}

TEST_CASE("Tune_OfADisplacedStore_HasPresetsWithNormalsMadeAgain_AndTheBytesOfApply") {
  const Workplace here;
  here.make_store();
  REQUIRE(here.plait({"displace", "s.plait", "d.plait", "--kind", "noise"}).status == 0);
  for (const std::string goal : {"size", "read"}) {
    CAPTURE(goal);
    const Outcome outcome =
        here.plait({"tune", "d.plait", "--seconds", "5", "--goal", goal, "--html", goal + ".html",
                    "--apply", "--out", goal + ".plait", "--json"});
    CAPTURE(outcome.errors);
    REQUIRE(outcome.status == 0);
    const nlohmann::json report = outcome.json(), applied = report["applied"];
    CHECK(std::ranges::any_of(report["choices"], [](const auto& choice) {
      return choice["name"] == "fast, normal made again";
    }));
    CHECK(applied["stored_bytes"].get<double>() ==
          Approx(applied["named_bytes"].get<double>()).epsilon(0.02));
    CHECK(here.plait({"digest", goal + ".plait"}).last_line() ==
          here.plait({"digest", "d.plait"}).last_line());
    // The command makes what the table names.
    std::string command = report["command"];
    std::istringstream words(command.substr(std::string("plait ").size()));
    std::vector<std::string> arguments;
    for (std::string word; words >> word;)
      arguments.push_back(word == "OUT" ? goal + "-by-hand.plait" : word);
    arguments.push_back("--json");
    const Outcome converted = here.plait(arguments);
    REQUIRE(converted.status == 0);
    CHECK(converted.json()["stored_bytes"] == applied["stored_bytes"]);
  }
  CHECK(content(here.path("read.html")).find("<html") != std::string::npos);
  // Nothing is replaced without --force.
  CHECK(here.plait({"tune", "d.plait", "--apply", "--out", "read.plait"}).status == 2);
  CHECK(here.plait({"tune", "d.plait", "--html", "read.html"}).status == 2);
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
  CHECK(program.runs_until_it_handles(SIGINT));
  // Wherever it is by now: either there is a report, or an error that says that there is none.
  CHECK(computes_for(program.process(), std::chrono::milliseconds(500)));
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
