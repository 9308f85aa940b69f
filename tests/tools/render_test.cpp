#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {

TEST_CASE("Render_ClosedAndOpenStores_GivesAPngOfTheSizeAskedFor") {
  const Workplace here;
  write_ply(here.path("closed.ply"), icosahedron());
  write_ply(here.path("open.ply"), sheet(5, 4));
  for (const std::string name : {"closed", "open"})
    for (const char* normals : {"--normals", "--limit"}) {
      CAPTURE(name, normals);
      const Outcome made = here.succeed(
          {"subdivide", name + ".ply", name + ".plait", "--levels", "4", "--force", normals});
      const Outcome drawn =
          here.succeed({"render", name + ".plait", name + ".png", "--size", "200x100", "--view",
                        "-20,40", "--up", "z", "--memory", "8M", "--force"});
      const std::string png = content_of(here.directory.path() / (name + ".png"));
      CHECK(png.substr(1, 3) == "PNG");
      CHECK(png.substr(16, 8) == std::string("\0\0\0\xc8\0\0\0\x64", 8));
      CHECK(png.size() > 2000);
    }
}

TEST_CASE("Render_ColoredByAnAttribute_ShowsItsRangeAndRefusesWhatIsNoNumber") {
  const Workplace here;
  {
    std::ofstream file(here.path("scan.ply"));
    const IndexedMesh mesh = sheet(20, 20);
    file << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nproperty short depth\n"
            "property float nx\nproperty float ny\nproperty float nz\nelement face "
         << mesh.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& p : mesh.positions)
      file << p.x << ' ' << p.y << ' ' << p.z << ' ' << (p.x < 10 ? -300 : 500) << " 0 0 1\n";
    for (const auto& f : mesh.faces) file << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  }
  here.succeed({"remesh", "scan.ply", "s.plait", "--faces", "40"});
  const Words arguments = {"render", "s.plait", "s.png",  "--size", "300x200",
                           "--up",   "z",       "--view", "0,80",   "--json"};
  here.succeed(arguments);
  const std::string plain = content_of(here.path("s.png"));
  auto colored = arguments;
  CHECK(here.plait(colored).status == 2);  // the picture is there
  CHECK(content_of(here.path("s.png")) == plain);
  colored.insert(colored.end(), {"--force", "--color-by", "depth"});
  const nlohmann::json report = here.plait(colored).json();
  CHECK(report["color_by"]["low"] == -300);
  CHECK(report["color_by"]["high"] == 500);
  CHECK(content_of(here.path("s.png")) != plain);
  for (const char* wrong : {"normal", "missing"}) {
    colored.back() = wrong;
    CHECK(here.plait(colored).status == 2);
  }
}

TEST_CASE("Render_WhatIsNotThere_IsRefusedAndLeavesNothing") {
  const Workplace here;
  write_ply(here.path("mesh.ply"), icosahedron());
  here.succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "2"});
  const auto before = here.names();
  for (const Words& options :
       std::vector<Words>{{"--level", "3"}, {"--size", "0x5"}, {"--view", "up"}, {"--up", "w"}}) {
    CAPTURE(options);
    CHECK(here.plait({"render", "s.plait", "s.png"}, options).status == 2);
    CHECK(here.names() == before);
  }
}

}  // namespace plait::test
