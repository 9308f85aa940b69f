// plait subdivide --resume: continues from the committed levels, and refuses a store of another
// run.
#include <signal.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "program.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

Names subdivide(int levels, Names further = {}) {
  Names arguments{"subdivide", "m.ply",   "s.plait", "--levels", std::to_string(levels),
                  "--json",    "--digest"};
  arguments.insert(arguments.end(), further.begin(), further.end());
  return arguments;
}

void make_mesh(const TemporaryDirectory& here, const char* name, const char* vertices) {
  REQUIRE(run(here.path(), {"generate", "torus", name, "--vertices", vertices}).status == 0);
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
      const TemporaryDirectory here(Medium::kMemory);
      make_mesh(here, "m.ply", "300");
      const Names options{"--backend", backend, "--scheme", scheme,
                          "--memory",  "4MiB",  "--block",  "16KiB"};
      Names whole = subdivide(4, options);
      whole[2] = "whole.plait";
      whole.push_back("--normals");
      const Outcome expected = run(here.path(), whole);
      REQUIRE(expected.status == 0);

      Names part = options;
      part.push_back("--resume");
      for (const int levels : {1, 3}) {
        const Outcome outcome = run(here.path(), subdivide(levels, part));
        REQUIRE(outcome.status == 0);
        CHECK(outcome.json()["resumed_level"] == (levels == 1 ? 0 : 1));
      }
      part.push_back("--normals");
      const Outcome outcome = run(here.path(), subdivide(4, part));
      REQUIRE(outcome.status == 0);
      CHECK(outcome.json()["digest"] == expected.json()["digest"]);
      const Outcome again = run(here.path(), subdivide(4, part));
      CHECK(again.json()["resumed_level"] == 4);
      CHECK(again.json()["digest"] == expected.json()["digest"]);
      CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
    }
  }
}

TEST_CASE("Resume_OfAStoreThatALibraryUserMade_GoesOn") {
  const TemporaryDirectory here;
  make_mesh(here, "m.ply", "300");
  {
    Store store =
        Store::create(here.path() / "s.plait",
                      lay_out(read_base_mesh(here.path() / "m.ply"), LayoutKind::kHilbert), {},
                      default_backends());
    add_base_positions(store);
    plait::subdivide(store, {.executor = ExecutorKind::kFused, .levels = 2});
    store.commit();
  }
  const Outcome outcome = run(here.path(), subdivide(4, {"--resume", "--normals"}));
  CAPTURE(outcome.errors);
  REQUIRE(outcome.status == 0);
  CHECK(outcome.json()["resumed_level"] == 2);
  Names whole = subdivide(4, {"--normals"});
  whole[2] = "whole.plait";
  REQUIRE(run(here.path(), whole).status == 0);
  const auto digest = [&](const char* store) {
    return run(here.path(), {"digest", store, "--json"}).json()["digest"];
  };
  CHECK(digest("s.plait") == digest("whole.plait"));
}

TEST_CASE("Resume_OfAnotherWork_IsRefusedAndChangesNothing") {
  const TemporaryDirectory here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  make_mesh(here, "other.ply", "400");
  REQUIRE(run(here.path(), subdivide(3, {"--resume", "--normals"})).status == 0);
  const auto digest = run(here.path(), {"digest", "s.plait", "--json"}).json()["digest"];
  Names other_mesh = subdivide(3, {"--resume"});
  other_mesh[1] = "other.ply";
  for (const Names& arguments : {other_mesh, subdivide(2, {"--resume"}), subdivide(4, {"--resume"}),
                                 subdivide(3, {"--resume", "--scheme", "midpoint"}),
                                 subdivide(3, {"--resume", "--precision", "float64"})}) {
    const Outcome outcome = run(here.path(), arguments);
    CAPTURE(outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.json()["error"]["code"] == "invalid_argument");
    CHECK(run(here.path(), {"digest", "s.plait", "--json"}).json()["digest"] == digest);
  }
  REQUIRE(run(here.path(), subdivide(3, {"--force", "--limit"})).status == 0);
  CHECK(run(here.path(), subdivide(4, {"--resume"})).status == 2);
}

TEST_CASE("Resume_FinishedButForNormals_MakesThem") {
  const TemporaryDirectory here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  REQUIRE(run(here.path(), subdivide(3, {"--resume"})).status == 0);
  const Outcome outcome = run(here.path(), subdivide(3, {"--resume", "--normals"}));
  REQUIRE(outcome.status == 0);
  Names whole = subdivide(3, {"--normals"});
  whole[2] = "whole.plait";
  REQUIRE(run(here.path(), whole).status == 0);
  CHECK(run(here.path(), {"digest", "s.plait"}).last_line() ==
        run(here.path(), {"digest", "whole.plait"}).last_line());
}

TEST_CASE("Resume_OfAMeshWithOneVertexMoved_IsRefused") {
  const TemporaryDirectory here(Medium::kMemory);
  make_mesh(here, "m.ply", "300");
  REQUIRE(run(here.path(), subdivide(2)).status == 0);
  IndexedMesh mesh = read_indexed_mesh(here.path() / "m.ply");
  mesh.positions[150].y += 0.0625;
  write_ply(here.path() / "moved.ply", mesh);
  Names moved = subdivide(3, {"--resume"});
  moved[1] = "moved.ply";
  const Outcome outcome = run(here.path(), moved);
  CHECK(outcome.status == 2);
  CHECK(outcome.json()["error"]["code"] == "invalid_argument");
}

TEST_CASE("Resume_OptionsThatTheStoreDecides_AreTakenFromItOrRefused") {
  const TemporaryDirectory here;
  make_mesh(here, "m.ply", "300");
  const Names as_made{"--resume",  "--backend",   "compressed", "--compress", "lz4",
                      "--block",   "16KiB",       "--layout",   "spatial",    "--scheme",
                      "butterfly", "--precision", "float64"};
  REQUIRE(run(here.path(), subdivide(2, as_made)).status == 0);
  for (const Names& other : std::vector<Names>{{"--backend", "pread"},
                                               {"--compress", "zstd:1"},
                                               {"--compress", "position=shuffle,lz4"},
                                               {"--block", "32KiB"},
                                               {"--layout", "rcm"},
                                               {"--scheme", "loop"},
                                               {"--precision", "float32"},
                                               {"--max-slot", "24"}}) {
    Names arguments = subdivide(3, {"--resume"});
    arguments.insert(arguments.end(), other.begin(), other.end());
    const Outcome outcome = run(here.path(), arguments);
    CAPTURE(other, outcome.errors);
    CHECK(outcome.status == 2);
    CHECK(outcome.errors.find(other[0]) != std::string::npos);
    CHECK(outcome.errors.find("resume s.plait") != std::string::npos);
  }
  CHECK(run(here.path(), subdivide(3, as_made)).status == 0);
  const Outcome open =
      run(here.path(), subdivide(4, {"--resume", "--backend", "auto", "--layout", "auto"}));
  REQUIRE(open.status == 0);
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
    const TemporaryDirectory here;
    make_mesh(here, "m.ply", "300");
    Names whole = subdivide(4, {"--normals"});
    whole[2] = "whole.plait";
    const Outcome expected = run(here.path(), whole);
    REQUIRE(expected.status == 0);
    REQUIRE(run(here.path(), subdivide(2, {"--normals", "--backend", backend})).status == 0);
    const Outcome outcome = run(here.path(), subdivide(4, {"--resume", "--normals"}));
    CAPTURE(outcome.errors);
    REQUIRE(outcome.status == 0);
    CHECK(outcome.json()["resumed_level"] == 2);
    CHECK(outcome.json()["digest"] == expected.json()["digest"]);
    const nlohmann::json info = run(here.path(), {"info", "s.plait", "--json"}).json();
    CHECK(info["attributes"].size() == 2);
    // The levels in between were not committed separately.
    CHECK(info["sequence"] == 2);
    CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
  }
}

TEST_CASE("Resume_Interrupted_LeavesTheLastCommitAndGoesOn") {
  const TemporaryDirectory here(Medium::kMemory);
  make_mesh(here, "m.ply", unless_sanitized("20000", "4000"));
  Names whole = subdivide(6);
  whole[2] = "whole.plait";
  const Outcome expected = run(here.path(), whole);
  REQUIRE(expected.status == 0);
  {
    const Outcome outcome = run_until(here.path(), subdivide(6, {"--resume"}), SIGINT, [&] {
      return has_file(here.path() / "s.plait", "attribute0.level04.");
    });
    CHECK(outcome.status == 128 + SIGINT);
    CHECK(outcome.json()["error"]["message"].get<std::string>().find("--resume") !=
          std::string::npos);
  }
  CHECK(run(here.path(), {"verify", "s.plait"}).status == 0);
  const Outcome outcome = run(here.path(), subdivide(6, {"--resume"}));
  REQUIRE(outcome.status == 0);
  CHECK(outcome.json()["resumed_level"] >= 3);
  CHECK(outcome.json()["digest"] == expected.json()["digest"]);
}

}  // namespace plait::test
