// The promises of the command line: exit statuses, --json, and no file left after an error.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

/// A directory with an icosahedron in it.
struct PlaceOfAMesh : Workplace {
  PlaceOfAMesh() { write_ply(path("mesh.ply"), icosahedron()); }
};

const Words kCommands = {"generate", "subdivide", "info",    "verify",  "repair",
                         "digest",   "bounds",    "export",  "convert", "displace",
                         "layout",   "paper",     "render",  "tune",    "check",
                         "compare",  "pass",      "publish", "serve"};

}  // namespace

TEST_CASE("Help_OfEveryCommand_HasExamplesAndStatusZero") {
  const PlaceOfAMesh here;
  CHECK(here.plait({"--help"}).output.find("Exit status") != std::string::npos);
  for (const std::string& command : kCommands) {
    CAPTURE(command);
    const Outcome outcome = here.plait({command, "--help"});
    CHECK(outcome.status == 0);
    CHECK(outcome.errors.empty());
    CHECK(outcome.output.find("Examples:\n  plait " + command) != std::string::npos);
    CHECK(outcome.output.find('\0') == std::string::npos);
  }
  CHECK(here.plait({"--version"}).output.find("plait ") == 0);
}

TEST_CASE("Usage_AnythingWrong_IsStatusTwoAndOneLine") {
  const PlaceOfAMesh here;
  const std::vector<Words> wrong = {
      {},
      {"fly"},
      {"subdivide"},
      {"subdivide", "mesh.ply", "s.plait"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "0"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "21"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2x"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--no-such-option"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--resume", "--force"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--resume", "--limit"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--resume", "--executor", "fused"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--resume", "--backend", "memory"},
      {"subdivide", "mesh.ply", "no/such/directory/s.plait", "--levels", "2", "--resume"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--memory", "12Q"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--memory", "1K"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--block", "5000"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--compress", "colour=lz4"},
      {"serve", "s.plait", "--port", "65536"},
      {"serve", "s.plait", "--port", "-1"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--threads", "1025"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--backend", "tape"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--backend", "pread", "--compress",
       "lz4"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--compress", "rot13"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--compress", "small", "--resume"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--executor", "magic"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--layout", "alphabetical"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--scheme", "catmull-clark"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--scheme", "midpoint", "--limit"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "2", "--precision", "float16"},
      {"subdivide", "mesh.ply", "--levels", "2"},
      {"subdivide", "missing.ply", "s.plait", "--levels", "2"},
      {"subdivide", "mesh.ply", "no/such/directory/s.plait", "--levels", "2"},
      {"info", "missing.plait"},
      {"verify", "missing.plait"},
      {"repair", "missing.plait"},
      {"digest", "missing.plait"},
      {"bounds", "missing.plait"},
      {"bounds"},
      {"digest", "missing.plait", "--level", "-1"},
      {"export", "missing.plait", "out.ply", "--level", "1000"},
      {"export", "missing.plait", "out.ply", "--level", "99999999999999999999"},
      {"export", "missing.plait", "-"},
      {"subdivide", "mesh.ply", "-", "--levels", "1"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "1000"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "-1"},
      {"convert", "missing.plait", "-"},
      {"displace", "missing.plait", "-"},
      {"displace", "missing.plait", "out.plait"},
      {"displace", "missing.plait", "out.plait", "--kind", "wavy"},
      {"displace", "missing.plait", "out.plait", "--amplitude", "2"},
      {"displace", "missing.plait", "out.plait", "--amplitude", "-0.1"},
      {"layout", "mesh.ply", "--layout", "alphabetical"},
      {"layout", "mesh.ply", "--memory", "1G"},
      {"layout", "mesh.ply", "m.base", "--layout", "rcm"},
      {"layout", "mesh.ply", "m.base", "--png", "spans.png"},
      {"layout", "mesh.ply", "m.base", "--memory", "much"},
      {"layout", "mesh.ply", "--png", "spans.jpg"},
      {"layout", "mesh.ply", "--png", "-"},
      {"generate", "torus", "-"},
      {"generate", "torus", "t.ply", "--vertices", "-5"},
      {"generate", "torus", "t.ply", "--seed", "-1"},
      {"render", "missing.plait", "out.png", "--up", "1"},
      {"generate", "teapot", "t.ply"},
      {"generate", "torus", "t.obj"},
      {"generate", "torus", "t.ply", "--vertices", "1"},
      {"export", "missing.plait", "out.off"},
      {"render", "missing.plait", "out.jpg"},
  };
  for (const Words& arguments : wrong) {
    std::string line;
    for (const std::string& argument : arguments) line += argument + " ";
    CAPTURE(line);
    const Outcome outcome = here.plait(arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.output.empty());
    CHECK(outcome.errors.find("plait: ") == 0);
    CHECK(outcome.error_lines() == 1);
    CHECK(outcome.errors.size() < 300);
    CHECK(here.names() == Words{"mesh.ply"});
  }
}

TEST_CASE("Usage_WhatIsNotThere_NamesWhatIs") {
  const PlaceOfAMesh here;
  const Words base = {"subdivide", "mesh.ply", "s.plait", "--levels", "1"};
  const auto errors_with = [&](const std::string& option, const std::string& value) {
    Words arguments = base;
    arguments.insert(arguments.end(), {option, value});
    return here.plait(arguments).errors;
  };
  CHECK(errors_with("--backend", "tape").find("pread") != std::string::npos);
  CHECK(errors_with("--executor", "magic").find("sweep") != std::string::npos);
  CHECK(errors_with("--layout", "x").find("hilbert") != std::string::npos);
  CHECK(errors_with("--scheme", "x").find("butterfly") != std::string::npos);
}

TEST_CASE("Subdivide_LimitOfASchemeWithoutLimitPositions_IsRefusedBeforeTheMeshIsRead") {
  const PlaceOfAMesh here;
  const Outcome outcome = here.plait(
      {"subdivide", "missing.ply", "s.plait", "--levels", "1", "--scheme", "butterfly", "--limit"});
  CHECK(outcome.status == 2);
  CHECK(outcome.errors.find("scheme butterfly has no limit positions (--limit)") !=
        std::string::npos);
}

TEST_CASE("Usage_NoSuchCommand_NamesTheCommandsAndTheNearest") {
  const PlaceOfAMesh here;
  for (const Words& arguments : std::vector<Words>{{}, {"foo"}, {"subdvide", "mesh.ply"}}) {
    const Outcome outcome = here.plait(arguments);
    CHECK(outcome.status == 2);
    for (const std::string& command : kCommands)
      CHECK(outcome.errors.find(command) != std::string::npos);
  }
  CHECK(here.plait({"subdvide"}).errors.find("did you mean subdivide?") != std::string::npos);
  CHECK(here.plait({"foo"}).errors.find("did you mean") == std::string::npos);
}

TEST_CASE("Names_InUpperCase_AreTakenAsInLowerCase") {
  const PlaceOfAMesh here;
  const std::vector<Words> all = {{"generate", "torus", "TORUS.PLY", "--vertices", "100"},
                                  {"subdivide", "TORUS.PLY", "s.plait", "--levels", "1"},
                                  {"export", "s.plait", "OUT.PLY"},
                                  {"export", "s.plait", "OUT.OBJ.GZ"},
                                  {"export", "s.plait", "OUT.STL.ZST"},
                                  {"layout", "OUT.PLY"},
                                  {"layout", "OUT.OBJ.GZ", "--png", "SPANS.PNG"},
                                  {"render", "s.plait", "OUT.PNG", "--size", "16x16"}};
  for (const Words& arguments : all) {
    here.succeed(arguments);
  }
}

TEST_CASE("Errors_OfOutputs_NameWhatTheUserNamed") {
  const PlaceOfAMesh here;
  here.succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "2"});
  // No file can be made in /proc.
  const std::vector<Words> all = {{"generate", "torus", "/proc/x.ply", "--vertices", "100"},
                                  {"subdivide", "mesh.ply", "/proc/x.plait", "--levels", "1"},
                                  {"export", "s.plait", "/proc/x.ply"},
                                  {"convert", "s.plait", "/proc/x.plait"},
                                  {"displace", "s.plait", "/proc/x.plait"},
                                  {"layout", "mesh.ply", "--layout", "rcm", "--png", "/proc/x.png"},
                                  {"render", "s.plait", "/proc/x.png", "--size", "16x16"}};
  for (const Words& arguments : all) {
    const Outcome outcome = here.plait(arguments);
    CAPTURE(arguments, outcome.errors);
    CHECK(outcome.status != 0);
    CHECK(outcome.errors.find("/proc/x.") != std::string::npos);
    CHECK(outcome.errors.find("partial") == std::string::npos);
  }
}

TEST_CASE("Json_OnErrors_IsOneObjectWithCodeAndMessage") {
  const PlaceOfAMesh here;
  const Outcome usage = here.plait({"subdivide", "mesh.ply", "--json", "--no-such-option"});
  CHECK(usage.status == 2);
  CHECK(usage.json()["error"]["code"] == "usage");
  const Outcome missing = here.plait({"info", "missing.plait", "--json"});
  CHECK(missing.status == 2);
  CHECK(missing.json()["error"]["code"] == "not_found");
}

TEST_CASE("Json_OfEveryCommand_IsOneObjectAndNothingElse") {
  const PlaceOfAMesh here;
  const std::vector<Words> all = {
      {"generate", "torus", "torus.ply", "--vertices", "100", "--json"},
      {"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--normals", "--json"},
      {"info", "s.plait", "--json"},
      {"check", "torus.ply", "--json"},
      {"compare", "torus.ply", "s.plait", "--samples", "1000", "--json"},
      {"verify", "s.plait", "--json"},
      {"verify", "s.plait", "--fast", "--json"},
      {"repair", "s.plait", "--json"},
      {"digest", "s.plait", "--json"},
      {"bounds", "s.plait", "--json"},
      {"export", "s.plait", "s.ply", "--json"},
      {"convert", "s.plait", "c.plait", "--backend", "compressed", "--json"},
      {"displace", "s.plait", "d.plait", "--json"},
      {"pass", "d.plait", "smooth", "--json"},
      {"layout", "torus.ply", "--json"},
      {"layout", "torus.ply", "t.base", "--json"},
      {"subdivide", "t.base", "of_base.plait", "--levels", "1", "--json"},
      {"render", "s.plait", "s.png", "--size", "64x48", "--json"}};
  for (const Words& arguments : all) {
    const Outcome outcome = here.succeed(arguments);
    CHECK(outcome.errors.empty());
    CHECK(outcome.json().is_object());
  }
}

TEST_CASE("Subdivide_RefusedMeshes_LeaveNothing") {
  const PlaceOfAMesh here;
  IndexedMesh broken = icosahedron();
  broken.faces.push_back(broken.faces[0]);
  write_ply(here.path("non_manifold.ply"), broken);
  std::ofstream(here.path("truncated.ply")) << "ply\nformat ascii 1.0\nelement vertex 3\n";
  std::ofstream(here.path("noise.obj")) << "v 1 2\nf 1 2 3\n";
  const Words before = here.names();
  for (const char* mesh : {"non_manifold.ply", "truncated.ply", "noise.obj"}) {
    CAPTURE(mesh);
    const Outcome outcome = here.plait({"subdivide", mesh, "s.plait", "--levels", "2"});
    CHECK(outcome.status == 2);
    CHECK(outcome.errors.find(mesh) != std::string::npos);
    CHECK(here.names() == before);
  }
}

TEST_CASE("Subdivide_TooSmallBudget_FailsWithStatusOneAndLeavesNothing") {
  const PlaceOfAMesh here;
  here.succeed({"generate", "torus", "torus.ply", "--vertices", "5000"});
  const Outcome outcome = here.plait(
      {"subdivide", "torus.ply", "s.plait", "--levels", "4", "--memory", "64K", "--json"});
  CHECK(outcome.status == 1);
  CHECK(outcome.json()["error"]["code"] == "budget");
  CHECK(here.names() == Words{"mesh.ply", "torus.ply"});
}

TEST_CASE("Output_ThatCannotBeWritten_IsStatusOne") {
  const PlaceOfAMesh here;
  Program full(here.directory.path(), {"layout", "mesh.ply"}, "/dev/full");
  const Outcome outcome = full.wait();
  CHECK(outcome.status == 1);
  CHECK(outcome.errors.find("standard output") != std::string::npos);
}

}  // namespace plait::test
