#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "program.h"
#include "support/test_meshes.h"

namespace plait::test {

TEST_CASE("Render_ClosedAndOpenStores_GivesAPngOfTheSizeAskedFor") {
  const TemporaryDirectory here;
  write_ply(here.path() / "closed.ply", icosahedron());
  write_ply(here.path() / "open.ply", sheet(5, 4));
  for (const std::string name : {"closed", "open"})
    for (const char* normals : {"--normals", "--limit"}) {
      CAPTURE(name, normals);
      const Outcome made = run(here.path(), {"subdivide", name + ".ply", name + ".plait",
                                             "--levels", "4", "--force", normals});
      REQUIRE(made.status == 0);
      const Outcome drawn =
          run(here.path(), {"render", name + ".plait", name + ".png", "--size", "200x100", "--view",
                            "-20,40", "--up", "z", "--memory", "8M", "--force"});
      CAPTURE(drawn.errors);
      REQUIRE(drawn.status == 0);
      const std::string png = content_of(here.path() / (name + ".png"));
      CHECK(png.substr(1, 3) == "PNG");
      CHECK(png.substr(16, 8) == std::string("\0\0\0\xc8\0\0\0\x64", 8));
      CHECK(png.size() > 2000);
    }
}

TEST_CASE("Render_ColoredByAnAttribute_ShowsItsRangeAndRefusesWhatIsNoNumber") {
  const TemporaryDirectory here;
  {
    std::ofstream file(here.path() / "scan.ply");
    const IndexedMesh mesh = sheet(20, 20);
    file << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nproperty short depth\n"
            "property float nx\nproperty float ny\nproperty float nz\nelement face "
         << mesh.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& p : mesh.positions)
      file << p.x << ' ' << p.y << ' ' << p.z << ' ' << (p.x < 10 ? -300 : 500) << " 0 0 1\n";
    for (const auto& f : mesh.faces) file << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  }
  REQUIRE(run(here.path(), {"remesh", "scan.ply", "s.plait", "--faces", "40"}).status == 0);
  const std::vector<std::string> arguments = {"render", "s.plait", "s.png",  "--size", "300x200",
                                              "--up",   "z",       "--view", "0,80",   "--json"};
  REQUIRE(run(here.path(), arguments).status == 0);
  const std::string plain = content_of(here.path() / "s.png");
  auto colored = arguments;
  CHECK(run(here.path(), colored).status == 2);  // the picture is there
  CHECK(content_of(here.path() / "s.png") == plain);
  colored.insert(colored.end(), {"--force", "--color-by", "depth"});
  const nlohmann::json report = run(here.path(), colored).json();
  CHECK(report["color_by"]["low"] == -300);
  CHECK(report["color_by"]["high"] == 500);
  CHECK(content_of(here.path() / "s.png") != plain);
  for (const char* wrong : {"normal", "missing"}) {
    colored.back() = wrong;
    CHECK(run(here.path(), colored).status == 2);
  }
}

TEST_CASE("Render_WhatIsNotThere_IsRefusedAndLeavesNothing") {
  const TemporaryDirectory here;
  write_ply(here.path() / "mesh.ply", icosahedron());
  REQUIRE(run(here.path(), {"subdivide", "mesh.ply", "s.plait", "--levels", "2"}).status == 0);
  const auto before = names_in(here.path());
  for (const std::vector<std::string>& options : std::vector<std::vector<std::string>>{
           {"--level", "3"}, {"--size", "0x5"}, {"--view", "up"}, {"--up", "w"}}) {
    std::vector<std::string> arguments = {"render", "s.plait", "s.png"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    CAPTURE(options);
    CHECK(run(here.path(), arguments).status == 2);
    CHECK(names_in(here.path()) == before);
  }
}

}  // namespace plait::test
