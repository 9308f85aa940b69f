// What check, import, remesh and subdivide say of a file, and what they take for it: precision,
// seams, numbers that are left out.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "plait/extend/attributed_mesh.h"
#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

using Catch::Matchers::Contains;

struct Doors : Workplace {
  void write(const char* name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  /// Different values of y of the finest level.
  std::size_t rows_of(const std::string& store) const {
    CHECK(plait({"export", store, "out.ply", "--force"}).status == 0);
    std::set<double> rows;
    for (const Vector3<double>& p :
         read_attributed_mesh(directory.path() / "out.ply").mesh.positions)
      rows.insert(p.y);
    return rows.size();
  }
};

/// 9 x 9 vertices, 0.125 apart, in metres of UTM: two levels and more.
std::string ground(const std::string& format) {
  const auto position = [](int i, int j) {
    return fmt::format("{:.3f} {:.3f} {:.3f}", 432100 + 0.125 * i, 5412345 + 0.125 * j,
                       0.01 * ((i * j) % 5));
  };
  std::string vertices, faces;
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 9; ++i) vertices += (format == "obj" ? "v " : "") + position(i, j) + "\n";
  std::string facets;
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i)
      for (const auto& corners : {std::array{0, 1, 10}, std::array{0, 10, 9}}) {
        const int first = 9 * j + i, more = format == "obj" ? 1 : 0;
        faces +=
            fmt::format("{} {} {} {}\n", format == "obj" ? "f" : "3", first + corners[0] + more,
                        first + corners[1] + more, first + corners[2] + more);
        facets += "facet normal 0 0 1\nouter loop\n";
        for (const int corner : corners)
          facets += "vertex " + position((first + corner) % 9, (first + corner) / 9) + "\n";
        facets += "endloop\nendfacet\n";
      }
  if (format == "obj") return vertices + faces;
  if (format == "off") return "OFF\n81 128 0\n" + vertices + faces;
  if (format == "stl") return "solid ground\n" + facets + "endsolid ground\n";
  return "ply\nformat ascii 1.0\nelement vertex 81\nproperty " + format + " x\nproperty " + format +
         " y\nproperty " + format +
         " z\nelement face 128\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
         faces;
}

/// An octahedron refined twice, each face with vertices of its own, and a colour at each vertex.
std::string coloured_soup() {
  const IndexedMesh mesh = torus_grid(8, 8);
  std::string vertices, faces;
  int first = 0;
  for (const auto& face : mesh.faces) {
    for (const VertexId vertex : face) {
      const Vector3<double>& p = mesh.positions[vertex];
      vertices += fmt::format("{} {} {} 64 128 255\n", p.x, p.y, p.z);
    }
    faces += fmt::format("3 {} {} {}\n", first, first + 1, first + 2);
    first += 3;
  }
  return fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty "
      "double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n{}{}",
      first, mesh.faces.size(), vertices, faces);
}

}  // namespace

TEST_CASE("Import_GroundFarAway_KeepsEveryHeightInEveryFormat") {
  const Doors here;
  for (const char* format : {"obj", "off", "stl", "float", "double"}) {
    INFO(format);
    const std::string name =
        std::string("ground.") + (std::string(format).size() > 3 ? "ply" : format);
    here.write(name.c_str(), ground(format));
    const Outcome outcome = here.plait({"import", name, "s.plait", "--force"});
    CHECK(outcome.status == 0);
    if (std::string(format) != "double")  // that is the type of the file
      CHECK_THAT(outcome.errors, Contains("positions are float64, because float32 moves"));
    CHECK(here.rows_of("s.plait") == 9);
    const Outcome narrow =
        here.plait({"import", name, "s.plait", "--force", "--precision", "float32"});
    CHECK(narrow.status == 0);
    CHECK_THAT(narrow.errors, Contains("float32 moves") && Contains("precision float64"));
    CHECK(here.rows_of("s.plait") < 9);
  }
}

TEST_CASE("SubdivideAndRemesh_GroundFarAway_TakeFloat64ByThemselves") {
  const Doors here;
  here.write("ground.stl", ground("stl"));
  const Outcome subdivided =
      here.plait({"subdivide", "ground.stl", "s.plait", "--levels", "1", "--scheme", "midpoint"});
  CHECK(subdivided.status == 0);
  CHECK_THAT(subdivided.errors, Contains("positions are float64"));
  CHECK(here.rows_of("s.plait") == 17);
  const Outcome remeshed = here.plait({"remesh", "ground.stl", "r.plait", "--faces", "20",
                                       "--levels", "2", "--json", "--samples", "1000"});
  CHECK(remeshed.status == 0);
  CHECK_THAT(remeshed.errors, Contains("positions are float64"));
  CHECK(remeshed.json()["precision"] == "float64");
  CHECK(here.rows_of("r.plait") > 9);
  CHECK(here.plait({"remesh", "ground.stl", "r.plait", "--force", "--faces", "20", "--precision",
                    "float32", "--json"})
            .json()["precision"] == "float32");
}

TEST_CASE("Subdivide_PrecisionAuto_IsTheDefaultAndLeavesSmallMeshesAlone") {
  const Doors here;
  write_ply(here.path("m.ply"), torus_grid(6, 5));
  const auto digest = [&](Words more) {
    more.insert(more.begin(),
                {"subdivide", "m.ply", "--levels", "2", "--backend", "memory", "--digest"});
    return here.plait(std::move(more)).last_line();
  };
  CHECK(digest({}) == digest({"--precision", "float32"}));
  CHECK(digest({}) == digest({"--precision", "auto"}));
  CHECK(digest({}) != digest({"--precision", "float64"}));
}

TEST_CASE("Plan_MeshThatFloat32DoesNotKeep_TakesFloat64OrRefuses") {
  const Doors here;
  here.write("ground.obj", ground("obj"));
  const Outcome planned =
      here.plait({"plan", "ground.obj", "ground.plan", "--levels", "1", "--parts", "2"});
  CHECK(planned.status == 0);
  CHECK_THAT(planned.errors, Contains("positions are float64"));
  for (const char* part : {"0", "1"}) here.succeed({"part", "ground.plan", part});
  here.succeed({"join", "ground.plan", "ground.plait"});
  here.succeed({"subdivide", "ground.obj", "one.plait", "--levels", "1"});
  CHECK(here.plait({"digest", "ground.plait"}).last_line() ==
        here.plait({"digest", "one.plait"}).last_line());

  here.write("huge.off", "OFF\n3 1 0\n0 0 0\n1e300 0 0\n0 1e300 0\n3 0 1 2\n");
  for (const std::string command : {"plan", "subdivide"}) {
    const auto make = [&](const char* precision) {
      Words words = {command, "huge.off",    command + ".out", "--levels",
                     "1",     "--precision", precision};
      if (command == "plan") words.insert(words.end(), {"--parts", "2"});
      return here.plait(words);
    };
    const Outcome refused = make("float32");
    CAPTURE(command, refused.errors);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.errors, Contains("no number for 2 vertices"));
    CHECK(make("auto").status == 0);
  }
}

TEST_CASE("MeshCommands_SeamFile_SayHowManyVerticesAndWeld") {
  const Doors here;
  here.write("soup.ply", coloured_soup());
  const std::string seams = "384 vertices have positions that others have: seams";
  CHECK_THAT(here.plait({"check", "soup.ply"}).output, Contains(seams));
  CHECK(here.plait({"check", "soup.ply", "--json"}).json()["seam_vertices"] == 384);
  const Outcome open = here.plait({"subdivide", "soup.ply", "s.plait", "--levels", "1", "--json"});
  CHECK_THAT(open.errors, Contains(seams));
  CHECK_THAT(here.plait({"remesh", "soup.ply", "r.plait", "--faces", "50"}).errors,
             Contains(seams));

  const Outcome checked = here.plait({"check", "--weld", "soup.ply"});
  CHECK_THAT(checked.output, Contains("soup.ply: an oriented manifold\n") &&
                                 Contains("64 vertices, 192 edges, 128 faces; 1 component, no "
                                          "border") &&
                                 !Contains("seams"));
  CHECK_THAT(checked.errors, Contains("320 vertices became others of the same position"));
  for (const Words& weld : {Words{"--weld"}, {"--weld", "1e-7"}, {"--weld=0"}}) {
    const Outcome closed = here.plait(
        {"subdivide", "soup.ply", "w.plait", "--levels", "1", "--force", "--json"}, weld);
    CHECK(closed.status == 0);
    CHECK_THAT(closed.errors, !Contains("seams"));
    CHECK(closed.json()["input"]["vertices"] == 64);
  }
  const Outcome imported = here.plait({"import", "soup.ply", "i.plait", "--weld", "--json"});
  CHECK(imported.status == 0);
  CHECK(imported.json()["vertices"] == 64);
  CHECK(imported.json()["merged_vertices"] == 320);
  const Outcome remeshed = here.plait(
      {"remesh", "soup.ply", "w.plait", "--force", "--faces", "50", "--weld", "1e-7", "--json"});
  CHECK(remeshed.json()["merged_vertices"] == 320);
  CHECK(remeshed.json()["seam_vertices"] == 0);
  const Outcome bad = here.plait({"check", "soup.ply", "--weld=-1"});
  CHECK(bad.status == 2);
}

TEST_CASE("Subdivide_AttributesOfAFile_AreNamedAsLeftOut") {
  const Doors here;
  here.write("soup.ply", coloured_soup());
  CHECK_THAT(here.plait({"subdivide", "soup.ply", "s.plait", "--levels", "1", "--weld"}).errors,
             Contains("left out: properties red, green, blue of 384 vertices"));
}

TEST_CASE("Subdivide_PinchedMesh_PointsToCheckAndRemesh") {
  const Doors here;
  here.write("pinched.off",
             "OFF\n7 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n-1 0 0\n-1 -1 0\n0 -1 0\n"
             "4 0 1 2 3\n4 0 4 5 6\n");
  const Outcome outcome = here.plait({"subdivide", "pinched.off", "s.plait", "--levels", "1"});
  CHECK(outcome.status == 2);
  CHECK_THAT(outcome.errors, Contains("vertex 0: expected its 2 faces to form one fan, found only "
                                      "1 in the fan of face 0") &&
                                 Contains("plait check") && Contains("plait remesh"));
}

}  // namespace plait::test
