// plait paper: counts against closed forms and against sets of points, pictures, the paper's own
// way against the other executors, and the command on a tiny stand-in.
#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "generate/generate.h"
#include "paper/mesh_figures.h"
#include "paper/models.h"
#include "paper/paper_way.h"
#include "paper/report.h"
#include "plait/digest.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/test_meshes.h"
#include "tools/program.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

/// A point of the refined mesh by what does not depend on a face: the base vertices around it, with
/// their weights at the finest level.
using Place = std::map<VertexId, std::int64_t>;

/// Vertices that a level creates, and those on base edges, from sets of points of all faces. Shares
/// no code with the edge index.
std::pair<std::uint64_t, std::uint64_t> naive_share(const BaseMesh& mesh, int level) {
  const auto places_of = [&](int at) {
    std::set<Place> places;
    const std::int64_t size = std::int64_t{1} << at, unit = std::int64_t{1} << (level - at);
    for (const auto& face : mesh.faces())
      for (std::int64_t j = 0; j <= size; ++j)
        for (std::int64_t i = 0; i + j <= size; ++i) {
          Place place;
          const std::int64_t weights[] = {size - i - j, i, j};
          for (std::size_t corner = 0; corner < 3; ++corner)
            if (weights[corner] != 0) place[face[corner]] = weights[corner] * unit;
          places.insert(place);
        }
    return places;
  };
  const std::set<Place> all = places_of(level), coarse = places_of(level - 1);
  std::uint64_t born = 0, on_base_edges = 0;
  for (const Place& place : all) {
    if (coarse.contains(place)) continue;
    ++born;
    if (place.size() == 2) ++on_base_edges;
  }
  return {born, on_base_edges};
}

Store memory_store(const BaseMesh& mesh) {
  Store store = Store::create({}, mesh, {.backend = "memory"}, default_backends());
  add_base_positions(store);
  return store;
}

const Names kTiny = {"paper", "--vertices", "200", "--levels", "2"};
Names with(Names arguments, const Names& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

TEST_CASE("BaseEdgeShares_EveryMesh_EqualCountsOverPoints") {
  for (const NamedMesh& named : all_meshes()) {
    INFO(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    if (mesh.face_count() > 200) continue;
    const nlohmann::json rows = paper::mesh_tables(mesh, 3)["shares"];
    REQUIRE(rows.size() == 3);
    for (const nlohmann::json& row : rows) {
      const auto [born, on_base_edges] = naive_share(mesh, row["level"].get<int>());
      CHECK(row["born"] == born);
      CHECK(row["on_base_edges"] == on_base_edges);
    }
  }
}

TEST_CASE("BaseEdgeShares_ClosedMesh_HalveWithEachLevel") {
  const nlohmann::json rows = paper::mesh_tables(BaseMesh::build(icosahedron()), 10)["shares"];
  REQUIRE(rows.size() == 10);
  for (const nlohmann::json& row : rows)
    CHECK(row["on_base_edges"].get<double>() / row["born"].get<double>() ==
          Approx(1.0 / static_cast<double>(1 << (row["level"].get<int>() - 1))));
  CHECK(rows[0]["replicated"] == 20 * 6);
  CHECK(rows[1]["replicated"] == 20 * 15);
}

TEST_CASE("MeshTables_Icosahedron_HaveCountsAndAllOrders") {
  const nlohmann::json tables = paper::mesh_tables(BaseMesh::build(icosahedron()), 3);
  CHECK(tables["vertices"] == 12);
  CHECK(tables["euler"] == 2);
  CHECK(tables["shares"][1]["born"] == 120);
  CHECK(tables["shares"][2]["vertices"] == 642);
  CHECK(tables["spans"].size() == 4);
}

TEST_CASE("WalkPatch_AllLevels_MeetsEveryVertexOnceAndNoCorner") {
  std::set<std::tuple<int, std::int64_t, std::int64_t>> met;
  paper::walk_patch(2, 5, [&](int level, std::int64_t i, std::int64_t j) {
    CHECK(met.insert({level, i, j}).second);
    CHECK(((i | j) & 1) == 1);  // new at this level
    CHECK(i + j <= 1 << level);
  });
  for (int level = 2; level <= 5; ++level) {
    const auto points = [](std::size_t side) { return (side + 1) * (side + 2) / 2; };
    const auto born = points(std::size_t{1} << level) - points(std::size_t{1} << (level - 1));
    CHECK(static_cast<std::size_t>(std::ranges::count_if(
              met, [&](const auto& vertex) { return std::get<0>(vertex) == level; })) == born);
  }
}

TEST_CASE("PaperWay_ClosedAndOpenMeshes_HasTheDigestOfTheFusedExecutor") {
  for (const BaseMesh& mesh : {BaseMesh::build(icosahedron()), BaseMesh::build(single_triangle()),
                               BaseMesh::build(generate(GeneratorKind::kOpenSheet, 60, 1))}) {
    Store expected = memory_store(mesh), made = memory_store(mesh);
    const SubdivideOptions how{.executor = ExecutorKind::kFused, .levels = 4, .normals = true};
    subdivide(expected, how);
    paper::make_in_paper_way(made, 4);
    CHECK(digest(made) == digest(expected));
  }
}

TEST_CASE("CircularBuffers_PaperSection42_AreTwiceTheSpanOnEachLevel") {
  // 2 x 10 edges of 1 + 4 + 16 records of 12 bytes, for positions and for normals.
  CHECK(paper::circular_buffer_bytes(10, 3) == 2 * 20 * 21 * 12);
}

TEST_CASE("Models_CountsOfThePaper_SatisfyTheEulerNumber") {
  for (const paper::Model& model : paper::models()) {
    CHECK(model.edges % 3 == 0);
    CHECK(model.vertices + model.edges * 2 / 3 <= model.edges + 2);
  }
  const IndexedMesh deo = paper::make_stand_in(paper::model_from_name("deo"), 0);
  const BaseMesh mesh = BaseMesh::build(deo);
  CHECK(mesh.vertex_count() == 26'016);
  CHECK(mesh.edge_count() == 78'084);
  CHECK_THROWS_AS(paper::model_from_name("bunny"), Error);
}

TEST_CASE("Chapter_ThePapersWork_HasItsMemoryBesideOurs") {
  const auto chapter_at = [](int levels) {
    const paper::Model& model = paper::model_from_name("deo");
    nlohmann::ordered_json report = {
        {"command", "c"}, {"date", "d"}, {"machine", "m"}, {"plait", "p"}, {"interrupted", false}};
    nlohmann::ordered_json one = {{"name", "deo"},
                                  {"source", "s"},
                                  {"is_stand_in", true},
                                  {"levels", levels},
                                  {"digests_equal", nullptr},
                                  {"pictures", nlohmann::json::array()}};
    one["tables"] = {{"vertices", model.vertices},
                     {"edges", model.edges},
                     {"faces", 52056},
                     {"euler", -12},
                     {"shares", nlohmann::json::array()},
                     {"spans", nlohmann::json::array()}};
    one["runs"] = {
        {{"executor", "fused"}, {"backend", "pread"}, {"budget_bytes", 1}, {"not_run", "x"}}};
    report["models"] = {one};
    return to_markdown(paper::make_chapter(report), ".");
  };
  const std::string same = chapter_at(5), other = chapter_at(3);
  CHECK(same.find("| 8:27 | 2:00 | 180 MB | 1 GB |") != std::string::npos);
  CHECK(same.find("| 5:26 | 2:00 | 640 MB | 1 GB |") != std::string::npos);
  CHECK(other.find("180 MB") == std::string::npos);
}

TEST_CASE("StandIn_FacesInRandomOrder_LeaveSomethingToOrdering") {
  const BaseMesh mesh = BaseMesh::build(paper::make_stand_in(paper::model_from_name("deo"), 2000));
  const nlohmann::json spans = paper::mesh_tables(mesh, 1)["spans"];
  CHECK(spans[0]["face"].get<int>() > 4 * spans[1]["face"].get<int>());  // given, spatial
}

TEST_CASE("Halved_FourPixels_AreTheirMean") {
  Image image(3, 2, {10, 20, 30});
  image.at(0, 0) = {20, 20, 30};
  image.at(1, 1) = {20, 24, 255};
  const Image half = paper::halved(image);
  CHECK(half.width() == 1);
  CHECK(half.height() == 1);
  CHECK(half.at(0, 0) == Rgb{15, 21, 86});
}

TEST_CASE("PaperCommand_TinyStandIn_RunsEveryExecutorToOneDigest") {
  const TemporaryDirectory here(Medium::kMemory);
  const Outcome outcome =
      run(here.path(), with(kTiny, {"--backend", "pread,memory", "--memory", "64M", "--json"}));
  INFO(outcome.errors);
  REQUIRE(outcome.status == 0);
  const nlohmann::json model = outcome.json()["models"][0];
  CHECK(model["is_stand_in"] == true);
  CHECK(model["tables"]["vertices"] == 200);
  REQUIRE(model["runs"].size() == 7);  // the paper's way, and three executors on two backends
  for (const nlohmann::json& row : model["runs"]) {
    CHECK(row["digest"] == model["digest"]);
    CHECK(row["seconds"].get<double>() > 0);
    CHECK(row["peak_rss_bytes"].get<std::uint64_t>() > 0);
  }
  CHECK(model["digests_equal"] == true);
  CHECK(names_in(here.path()).empty());
}

TEST_CASE("PaperCommand_Pages_HaveTablesAndPictures") {
  const TemporaryDirectory here(Medium::kMemory);
  write_ply(here.path() / "own.ply", icosahedron());
  const Names arguments = {"paper", "--mesh",     "own.ply",        "--levels",
                           "3",     "--executor", "fused",          "--backend",
                           "pread", "--markdown", "report/paper.md"};
  const Outcome outcome = run(here.path(), arguments);
  INFO(outcome.errors);
  REQUIRE(outcome.status == 0);
  const std::filesystem::path report = here.path() / "report";  // the command makes it
  CHECK(names_in(here.path()) == Names{"own.ply", "report"});
  CHECK(names_in(report) == Names{"images", "paper.md"});
  CHECK(names_in(report / "images") ==
        Names{"paper-deo-spans-given.png", "paper-deo-spans-spatial.png"});
  const std::string page = content_of(report / "paper.md");
  for (const char* part :
       {"Base mesh: own.ply.", "](images/paper-deo-spans-given.png)",
        "| 3 | 480 | 120 | 25.00 % | 642 |", "other work, so its rows are not here", "| fused |",
        "plait paper --mesh own.ply"}) {
    CAPTURE(part);
    CHECK(page.find(part) != std::string::npos);
  }
  CHECK(page.find("| the paper,") == std::string::npos);  // it went to level 5
  CHECK(page.find("plait-scratch") == std::string::npos);

  const Outcome in_file =
      run(here.path(), {"paper", "--mesh", "own.ply", "--markdown", "own.ply/page.md"});
  CHECK(in_file.status != 0);
  CHECK(in_file.error_lines() == 1);
  CHECK(in_file.errors.find("create " + (here.path() / "own.ply").string()) != std::string::npos);

  // A second run replaces nothing unless it is told to.
  const Outcome again = run(here.path(), arguments);
  CHECK(again.status == 2);
  CHECK(again.errors.find("paper.md") != std::string::npos);
  CHECK(content_of(report / "paper.md") == page);
}

TEST_CASE("PaperCommand_BadUsage_IsRefusedInOneLine") {
  const TemporaryDirectory here(Medium::kMemory);
  const std::vector<Names> wrong = {
      {"paper", "--model", "bunny"},
      {"paper", "--vertices", "3"},
      {"paper", "--vertices", "200", "--levels", "13"},
      {"paper", "--vertices", "200", "--mesh", "m.ply"},
      {"paper", "--vertices", "200", "--model", "deo,david"},
      {"paper", "--mesh", "missing.ply"},
      {"paper", "--vertices", "200", "--executor", "magic"},
      {"paper", "--vertices", "200", "--backend", "tape"},
      {"paper", "--vertices", "200", "--memory", "12Q"},
      {"paper", "--vertices", "200", "--directory", "no/such"},
      {"paper", "--vertices", "200", "--pictures", "no/such"},
      {"paper", "--vertices", "200", "--markdown", "-"},
      {"paper", "deo"},
  };
  for (const Names& arguments : wrong) {
    CAPTURE(arguments);
    const Outcome outcome = run(here.path(), arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.output.empty());
    CHECK(outcome.error_lines() == 1);
    CHECK(names_in(here.path()).empty());
  }
}

TEST_CASE("PaperCommand_Signal_ReportsWhatThereIsAndLeavesNothing") {
  const TemporaryDirectory here(Medium::kMemory);
  // Far more runs than there is time for.
  std::string budgets = "64M";
  for (int i = 0; i < 2000; ++i) budgets += ",64M";
  Program program(here.path(), with(kTiny, {"--backend", "pread", "--executor", "fused", "--memory",
                                            budgets, "--json"}));
  CHECK(program.runs_until([&] { return !names_in(here.path()).empty(); }));
  ::kill(program.process(), SIGTERM);
  const Outcome outcome = program.wait();
  CHECK(outcome.status == 128 + SIGTERM);
  const nlohmann::json report = outcome.json();
  CHECK(report["interrupted"] == true);
  CHECK(names_in(here.path()).empty());
}

}  // namespace plait::test
