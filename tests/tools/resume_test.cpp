// plait subdivide --resume: continues from the committed levels, and refuses a store of another
// run.
#include <signal.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"
#include "workplace.h"

namespace plait::test {
namespace {

Words subdivide(int levels, Words further = {}) {
  Words arguments{"subdivide", "m.ply",   "s.plait", "--levels", std::to_string(levels),
                  "--json",    "--digest"};
  arguments.insert(arguments.end(), further.begin(), further.end());
  return arguments;
}

void make_mesh(const Workplace& here, const char* name, const char* vertices) {
  here.succeed({"generate", "torus", name, "--vertices", vertices});
}

/// Whether the directory is there and has a file whose name begins like this.
bool has_file(const std::filesystem::path& directory, const std::string& beginning) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().filename().native().starts_with(beginning)) return true;
  return false;
}

}  // namespace

TEST_CASE("Resume_LevelByLevel_GivesWhatOneRunGives") {
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    for (const std::string scheme : {"loop", "butterfly", "midpoint"}) {
      if (unless_sanitized(false, true) && (scheme == "loop") != (backend != "pread")) continue;
      CAPTURE(backend, scheme);
      const Workplace here(Medium::kMemory);
      make_mesh(here, "m.ply", "300");
      const Words options{"--backend", backend, "--scheme", scheme,
                          "--memory",  "4MiB",  "--block",  "16KiB"};
      Words whole = subdivide(4, options);
      whole[2] = "whole.plait";
      whole.push_back("--normals");
      const Outcome expected = here.succeed(whole);

      Words part = options;
      part.push_back("--resume");
      for (const int levels : {1, 3}) {
        const Outcome outcome = here.succeed(subdivide(levels, part));
        CHECK(outcome.json()["resumed_level"] == (levels == 1 ? 0 : 1));
      }
      part.push_back("--normals");
      const Outcome outcome = here.succeed(subdivide(4, part));
      CHECK(outcome.json()["digest"] == expected.json()["digest"]);
      const Outcome again = here.plait(subdivide(4, part));
      CHECK(again.json()["resumed_level"] == 4);
      CHECK(again.json()["digest"] == expected.json()["digest"]);
      CHECK(here.plait({"verify", "s.plait"}).status == 0);
    }
  }
}

TEST_CASE("Resume_OfAnotherWork_IsRefusedAndChangesNothing") {
  const Workplace here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  make_mesh(here, "other.ply", "400");
  here.succeed(subdivide(3, {"--resume", "--normals"}));
  const auto digest = here.plait({"digest", "s.plait", "--json"}).json()["digest"];
  Words other_mesh = subdivide(3, {"--resume"});
  other_mesh[1] = "other.ply";
  for (const Words& arguments : {other_mesh, subdivide(2, {"--resume"}), subdivide(4, {"--resume"}),
                                 subdivide(3, {"--resume", "--scheme", "midpoint"}),
                                 subdivide(3, {"--resume", "--precision", "float64"})}) {
    const Outcome outcome = here.plait(arguments);
    CAPTURE(outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.json()["error"]["code"] == "invalid_argument");
    CHECK(here.plait({"digest", "s.plait", "--json"}).json()["digest"] == digest);
  }
  here.succeed(subdivide(3, {"--force", "--limit"}));
  CHECK(here.plait(subdivide(4, {"--resume"})).status == 2);
}

TEST_CASE("Resume_FinishedButForNormals_MakesThem") {
  const Workplace here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  here.succeed(subdivide(3, {"--resume"}));
  const Outcome outcome = here.succeed(subdivide(3, {"--resume", "--normals"}));
  Words whole = subdivide(3, {"--normals"});
  whole[2] = "whole.plait";
  here.succeed(whole);
  CHECK(here.plait({"digest", "s.plait"}).last_line() ==
        here.plait({"digest", "whole.plait"}).last_line());
}

TEST_CASE("Resume_OfAMeshWithOneVertexMoved_IsRefused") {
  const Workplace here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  here.succeed(subdivide(2));
  IndexedMesh mesh = read_indexed_mesh(here.path("m.ply"));
  mesh.positions[150].y += 0.0625;
  write_ply(here.path("moved.ply"), mesh);
  Words moved = subdivide(3, {"--resume"});
  moved[1] = "moved.ply";
  const Outcome outcome = here.plait(moved);
  CHECK(outcome.status == 2);
  CHECK(outcome.json()["error"]["code"] == "invalid_argument");
}

TEST_CASE("Resume_OptionsThatTheStoreDecides_AreTakenFromItOrRefused") {
  const Workplace here;
  make_mesh(here, "m.ply", "300");
  const Words as_made{"--resume",  "--backend",   "compressed", "--compress", "lz4",
                      "--block",   "16KiB",       "--layout",   "spatial",    "--scheme",
                      "butterfly", "--precision", "float64"};
  here.succeed(subdivide(2, as_made));
  for (const Words& other : std::vector<Words>{{"--backend", "pread"},
                                               {"--compress", "zstd:1"},
                                               {"--compress", "position=shuffle,lz4"},
                                               {"--block", "32KiB"},
                                               {"--layout", "rcm"},
                                               {"--scheme", "loop"},
                                               {"--precision", "float32"},
                                               {"--max-slot", "24"}}) {
    Words arguments = subdivide(3, {"--resume"});
    arguments.insert(arguments.end(), other.begin(), other.end());
    const Outcome outcome = here.plait(arguments);
    CAPTURE(other, outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.errors.find(other[0]) != std::string::npos);
    CHECK(outcome.errors.find("resume s.plait") != std::string::npos);
  }
  CHECK(here.plait(subdivide(3, as_made)).status == 0);
  const Outcome open =
      here.succeed(subdivide(4, {"--resume", "--backend", "auto", "--layout", "auto"}));
  CHECK(open.json()["resumed_level"] == 3);
  CHECK(open.json()["backend"] == "compressed");
  CHECK(open.json()["backend_reason"] == "the backend of the store");
  CHECK(open.json()["scheme"] == "butterfly");
  CHECK(open.json()["precision"] == "float64");
}

TEST_CASE("Resume_OfAStoreWithNormals_MakesThemAnewAtTheFinerLevel") {
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    CAPTURE(backend);
    const Workplace here;
    make_mesh(here, "m.ply", "300");
    Words whole = subdivide(4, {"--normals"});
    whole[2] = "whole.plait";
    const Outcome expected = here.succeed(whole);
    here.succeed(subdivide(2, {"--normals", "--backend", backend}));
    const Outcome outcome = here.succeed(subdivide(4, {"--resume", "--normals"}));
    CHECK(outcome.json()["resumed_level"] == 2);
    CHECK(outcome.json()["digest"] == expected.json()["digest"]);
    const nlohmann::json info = here.report({"info", "s.plait"});
    CHECK(info["attributes"].size() == 2);
    // The levels in between were not committed separately.
    CHECK(info["sequence"] == 2);
    CHECK(here.plait({"verify", "s.plait"}).status == 0);
  }
}

TEST_CASE("Resume_Interrupted_LeavesTheLastCommitAndGoesOn") {
  const Workplace here(Medium::kMemory);
  make_mesh(here, "m.ply", unless_sanitized("20000", "4000"));
  Words whole = subdivide(6);
  whole[2] = "whole.plait";
  const Outcome expected = here.succeed(whole);
  {
    const Outcome outcome =
        run_until(here.directory.path(), subdivide(6, {"--resume"}), SIGINT,
                  [&] { return has_file(here.path("s.plait"), "attribute0.level04."); });
    CHECK(outcome.status == 128 + SIGINT);
    CHECK(outcome.json()["error"]["message"].get<std::string>().find("--resume") !=
          std::string::npos);
  }
  CHECK(here.plait({"verify", "s.plait"}).status == 0);
  const Outcome outcome = here.succeed(subdivide(6, {"--resume"}));
  CHECK(outcome.json()["resumed_level"] >= 3);
  CHECK(outcome.json()["digest"] == expected.json()["digest"]);
}

}  // namespace plait::test
