// plait prune, and every other command over the store that it makes: each works or refuses.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

struct PrunedWorkplace : Workplace {
  PrunedWorkplace() {
    IndexedMesh mesh = sheet(6, 6);
    for (Vector3<double>& at : mesh.positions) at.z = 0;
    mesh.positions.back().z = 1;
    write_ply(path("mesh.ply"), mesh);
    succeed({"subdivide", "mesh.ply", "whole.plait", "--levels", "3", "--normals", "--backend",
             "pread"});
  }
};

}  // namespace

TEST_CASE("Prune_OfAStore_IsUsedByEveryCommandOrRefusedInWords") {
  const PrunedWorkplace here;
  const Outcome made =
      here.succeed({"prune", "whole.plait", "pruned.plait", "--max-distance", "0.2%", "--json"});
  CHECK(made.json()["vertices"] < made.json()["from_vertices"]);
  CHECK(made.json()["distance"] <= made.json()["max_distance"]);
  CHECK(made.json()["depths"].size() > 1);

  const Outcome against =
      here.plait({"digest", "pruned.plait", "--against", "whole.plait", "--json"});
  CHECK(against.status == 0);
  CHECK(against.json()["equal"] == true);
  CHECK(here.plait({"digest", "whole.plait", "--against", "pruned.plait"}).status == 1);
  const Outcome shape = here.plait({"export", "pruned.plait", "shape.ply", "--json"});
  CHECK(shape.json()["vertices"] == made.json()["vertices"]);
  CHECK(here.plait({"check", "shape.ply", "--json"}).json()["repaired"]["euler_number"] == 1);
  const Outcome info = here.plait({"info", "pruned.plait", "--json"});
  CHECK(info.json()["finest"]["vertices"] == made.json()["vertices"]);
  CHECK(info.json()["depths"] == made.json()["depths"]);

  const std::vector<Words> used = {
      {"verify", "pruned.plait"},
      {"info", "pruned.plait"},
      {"digest", "pruned.plait"},
      {"digest", "pruned.plait", "--level", "1"},
      {"repair", "pruned.plait", "--dry-run"},
      {"bounds", "pruned.plait"},
      {"clean", "."},
      {"convert", "pruned.plait", "copy.plait", "--compress", "fast", "--verify"},
      {"convert", "pruned.plait", "default.plait", "--compress", "default", "--verify"},
      {"convert", "default.plait", "small.plait", "--compress", "small", "--verify"},
      {"digest", "small.plait", "--against", "whole.plait"},
      {"verify", "small.plait"},
      {"tune", "pruned.plait", "--seconds", "1"},
      {"compare", "whole.plait", "pruned.plait", "--samples", "1000"},
      {"export", "pruned.plait", "mesh.ply", "--attribute", "normal", "--force"},
      {"export", "pruned.plait", "mesh.vtp", "--attribute", "normal"},
      {"export", "pruned.plait", "mesh.obj"},
      {"export", "pruned.plait", "mesh.off", "--level", "2"},
      {"export", "pruned.plait", "mesh.stl"},
      {"export", "pruned.plait", "mesh.glb", "--attribute", "normal"},
      {"render", "pruned.plait", "picture.png", "--size", "64x64"},
      {"render", "pruned.plait", "depth.png", "--size", "64x64", "--color-by", "depth"},
      {"publish", "pruned.plait", "published", "--page"},
      {"export", "pruned.plait", "pieces.pvtp", "--pieces", "3"},
      {"pass", "pruned.plait", "smooth", "smooth.plait"},
      {"pass", "pruned.plait", "noise", "noisy.plait"},
      {"pass", "pruned.plait", "normals", "shaded.plait"},
      {"displace", "pruned.plait", "moved.plait"},
      {"verify", "moved.plait"},
      {"check", "mesh.ply"}};
  for (const auto& command : used) {
    here.succeed(command);
  }
  const std::vector<Words> refused = {{"prune", "pruned.plait", "other", "--max-distance", "0"},
                                      {"plan", "pruned.plait", "other", "--pass", "smooth"}};
  for (const auto& command : refused) {
    CAPTURE(command);
    const Outcome outcome = here.plait(command);
    CAPTURE(outcome.errors);
    CHECK(outcome.status != 0);
    CHECK(outcome.errors.find("depth") != std::string::npos);
    CHECK_FALSE(here.has("other"));
  }
  CHECK(here.plait({"digest", "pruned.plait", "--against", "whole.plait"}).status == 0);
  CHECK(here.plait({"check", "mesh.stl", "--json"}).json()["repaired"]["euler_number"] == 1);

  const Outcome filled = here.succeed(
      {"convert", "pruned.plait", "uniform.plait", "--depth", "uniform", "--verify", "--json"});
  CHECK(filled.json()["filled_vertices"] > 0);
  CHECK(filled.json()["filled_vertices"].get<int>() + made.json()["vertices"].get<int>() ==
        filled.json()["vertices"]);
  CHECK(filled.errors.find("midpoint") != std::string::npos);
  CHECK(filled.json()["left_out_max_error"].empty());
  REQUIRE(here.plait({"convert", "pruned.plait", "rounded.plait", "--max-error", "1e-4"}).status ==
          0);
  const Outcome unrounded =
      here.succeed({"convert", "rounded.plait", "unrounded.plait", "--depth", "uniform", "--json"});
  CHECK(unrounded.json()["left_out_max_error"]["position"]["bound"] == 1e-4);
  const Outcome told =
      here.plait({"convert", "rounded.plait", "unrounded.plait", "--depth", "uniform", "--force"});
  CHECK(told.output.find("position: the record of an earlier rounding is not taken along") !=
        std::string::npos);
  // A rounding without filled vertices is taken along.
  CHECK(here.plait({"convert", "rounded.plait", "same.plait", "--json"})
            .json()["left_out_max_error"]
            .is_null());
  CHECK(here.plait({"subdivide", "uniform.plait", "finer.plait", "--levels", "4"}).status != 0);
  CHECK(here.plait({"pass", "uniform.plait", "smooth"}).status == 0);
}

TEST_CASE("Render_OfEqualDepths_GivesThePictureOfAllLevels") {
  const PrunedWorkplace here;
  here.succeed({"prune", "whole.plait", "equal.plait", "--vertices", "1000000"});
  const auto picture = [&](const std::string& store) {
    const std::string name = store + ".png";
    const Outcome made =
        here.plait({"render", store + ".plait", name, "--size", "200x150", "--json"});
    CHECK(made.status == 0);
    CHECK(made.json()["triangles"] == 72 * 64);
    std::ostringstream bytes;
    bytes << std::ifstream(here.directory.path() / name, std::ios::binary).rdbuf();
    return bytes.str();
  };
  CHECK(picture("equal") == picture("whole"));
}

}  // namespace plait::test
