// plait check and plait compare.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

struct ScanWorkplace : Workplace {
  void write(const char* name, const IndexedMesh& mesh) const { write_ply(path(name), mesh); }
};

IndexedMesh shifted(IndexedMesh mesh, double by) {
  for (Vector3<double>& p : mesh.positions) p.z += by;
  return mesh;
}

IndexedMesh flat_sheet() {
  IndexedMesh mesh = sheet(8, 8);
  for (Vector3<double>& p : mesh.positions) p.z = 0;
  return mesh;
}

}  // namespace

TEST_CASE("Check_CleanMesh_SaysSoWithItsFigures") {
  const ScanWorkplace here;
  here.write("mesh.ply", torus_grid(6, 5));
  const Outcome outcome = here.plait({"check", "mesh.ply"});
  CHECK(outcome.status == 0);
  CHECK(outcome.output ==
        "mesh.ply: an oriented manifold\n30 vertices, 90 edges, 60 faces; 1 component, no border, "
        "Euler number 0\n");
}

TEST_CASE("Check_BadMesh_CountsWhatIsWrongAndChangesNothing") {
  const ScanWorkplace here;
  IndexedMesh mesh = torus_grid(6, 5);
  mesh.faces.push_back(mesh.faces[4]);
  mesh.faces.push_back({1, 1, 2});
  std::swap(mesh.faces[9][0], mesh.faces[9][1]);
  mesh.positions.push_back({5, 5, 5});
  here.write("mesh.ply", mesh);
  const std::string before = content_of(here.path("mesh.ply"));
  const nlohmann::json found = here.plait({"check", "mesh.ply", "--json"}).json()["found"];
  CHECK(found["clean"] == false);
  CHECK(found["duplicate_faces"] == 1);
  CHECK(found["degenerate_faces"] == 1);
  CHECK(found["turned_faces"] == 1);
  CHECK(found["unused_vertices"] == 1);
  CHECK(found["non_manifold_edges"] == 0);
  CHECK_THAT(here.plait({"check", "mesh.ply"}).output,
             Catch::Matchers::Contains("  1 faces given twice: removed\n"));
  CHECK(content_of(here.path("mesh.ply")) == before);
  CHECK(here.names() == Words{"mesh.ply"});
}

TEST_CASE("Check_FoldedMesh_SaysHowManyEdgesAndWhatThatMeans") {
  const ScanWorkplace here;
  here.write("mesh.ply",
             {{{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {1, 0.5, 0.01}}, {{1, 0, 2}, {0, 1, 3}}});
  const Outcome outcome = here.plait({"check", "mesh.ply"});
  CHECK_THAT(outcome.output, Catch::Matchers::Contains("folded over 150 degrees: 1\n") &&
                                 Catch::Matchers::Contains("--no-foldover"));
  CHECK(here.plait({"check", "mesh.ply", "--json"}).json()["repaired"]["folded_edges"] == 1);
}

TEST_CASE("Check_MoebiusStrip_IsRefusedWithItsPlace") {
  const ScanWorkplace here;
  here.write("strip.ply", {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}},
                           {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}, {4, 1, 5}, {5, 1, 0}}});
  const Outcome outcome = here.plait({"check", "strip.ply"});
  CHECK(outcome.status == 2);
  CHECK(outcome.error_lines() == 1);
  CHECK_THAT(outcome.errors, Catch::Matchers::Contains("strip.ply: the edge of the vertices"));
}

TEST_CASE("Remesh_Report_SaysHowManyBaseMeshesAndHowEvenTheSmallFacesAre") {
  const ScanWorkplace here;
  here.write("scan.ply", torus_grid(30, 20));
  const Words arguments = {"remesh",    "scan.ply", "s.plait", "--faces",      "40",
                           "--samples", "2000",     "--force", "--no-foldover"};
  const Outcome text = here.succeed(arguments);
  CHECK_THAT(text.output, Catch::Matchers::Contains("small faces within a base face") &&
                              Catch::Matchers::Contains(", 0 of them turned over"));
  CHECK_THAT(text.output, !Catch::Matchers::Contains("times, until"));
  Words with_json = arguments;
  with_json.push_back("--json");
  const nlohmann::json report = here.plait(with_json).json();
  CHECK(report["base_meshes"] == 1);
  CHECK(report["turned_faces"] == 0);
  // Both forms of the report have the same figures.
  const double percentile = report["area_spread"]["percentile_90"].get<double>(),
               share = report["area_spread"]["share_within_4"].get<double>();
  CHECK(percentile > 1);
  CHECK_THAT(text.output, Catch::Matchers::Contains(
                              fmt::format("at most {:.1f} in 90 % of the base faces, at most 4 in "
                                          "{:.1f} %\n",
                                          percentile, 100 * share)));
}

TEST_CASE("Remesh_MinComponentAndFillHoles_RepairWhatIsAskedForAndCountIt") {
  const ScanWorkplace here;
  IndexedMesh scan = side_by_side({torus_grid(30, 20), tetrahedron()});
  scan.faces.erase(scan.faces.begin());  // a hole of three edges in the torus
  here.write("scan.ply", scan);
  const auto remeshed = [&](const Words& options) {
    const Outcome outcome = here.succeed(
        {"remesh", "scan.ply", "s.plait", "--faces", "60", "--samples", "0", "--force", "--json"},
        options);
    return outcome.json();
  };
  const nlohmann::json as_it_is = remeshed({});
  CHECK(as_it_is["repairs"]["small_components"] == 0);
  CHECK(as_it_is["repairs"]["filled_holes"] == 0);
  CHECK(as_it_is["base_figures"]["components"] == 2);
  CHECK(as_it_is["base_figures"]["borders"] == 1);
  CHECK(remeshed({"--fill-holes", "2", "--min-component", "4"})["base_figures"] ==
        as_it_is["base_figures"]);
  const nlohmann::json repaired = remeshed({"--fill-holes", "3", "--min-component", "5"});
  CHECK(repaired["repairs"]["small_components"] == 1);
  CHECK(repaired["repairs"]["filled_holes"] == 1);
  CHECK(repaired["base_figures"]["components"] == 1);
  CHECK(repaired["base_figures"]["borders"] == 0);
}

TEST_CASE("Compare_ParallelSheets_GivesTheirGapBothWays") {
  const ScanWorkplace here;
  here.write("low.ply", flat_sheet());
  here.write("high.ply", shifted(flat_sheet(), 0.5));
  const nlohmann::json report =
      here.plait({"compare", "low.ply", "high.ply", "--samples", "10000", "--json"}).json();
  for (const char* direction : {"a_to_b", "b_to_a"}) {
    CHECK(report[direction]["samples"] == 10000);
    CHECK(report[direction]["max"].get<double>() == Approx(0.5));
    CHECK(report[direction]["rms"].get<double>() == Approx(0.5));
  }
}

TEST_CASE("Compare_StoreWithItsExport_IsTheSameSurface") {
  const ScanWorkplace here;
  here.write("mesh.ply", random_sheet(3, 40));
  for (const char* level : {"1", "3"}) {
    REQUIRE(here.plait({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--force"}).status ==
            0);
    REQUIRE(here.plait({"export", "s.plait", "level.ply", "--level", level, "--force"}).status ==
            0);
    const nlohmann::json report = here.plait({"compare", "s.plait", "level.ply", "--level", level,
                                              "--samples", "5000", "--json"})
                                      .json();
    CHECK(report["a_to_b"]["max_percent"].get<double>() < 1e-5);
    CHECK(report["b_to_a"]["max_percent"].get<double>() < 1e-5);
  }
  const nlohmann::json coarse =
      here.plait({"compare", "s.plait", "mesh.ply", "--samples", "5000", "--json"}).json();
  CHECK(coarse["a_to_b"]["rms_percent"].get<double>() > 1e-3);
}

TEST_CASE("Compare_AnyNumberOfThreads_GivesTheSameFigures") {
  const ScanWorkplace here;
  here.write("a.ply", random_sphere(1, 100));
  here.write("b.ply", random_sphere(2, 100));
  std::vector<nlohmann::json> reports;
  for (const char* threads : {"1", "2"})
    reports.push_back(here.plait({"compare", "a.ply", "b.ply", "--samples", "40000", "--threads",
                                  threads, "--json"})
                          .json());
  CHECK(reports[0]["a_to_b"] == reports[1]["a_to_b"]);
  CHECK(reports[0]["b_to_a"] == reports[1]["b_to_a"]);
}

TEST_CASE("Compare_WithoutASurface_IsRefused") {
  const ScanWorkplace here;
  here.write("mesh.ply", octahedron());
  std::ofstream(here.path("empty.off")) << "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n";
  for (const Words& arguments : {Words{"compare", "mesh.ply", "missing.ply"},
                                 {"compare", "mesh.ply", "empty.off"},
                                 {"compare", "mesh.ply", "."},
                                 {"compare", "mesh.ply", "mesh.ply", "--samples", "0"}}) {
    CAPTURE(arguments[2]);
    const Outcome outcome = here.plait(arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.error_lines() == 1);
  }
}

}  // namespace plait::test
