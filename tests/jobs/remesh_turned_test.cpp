// Small faces that are turned over: they are marked, refused with their places, or gone after base
// meshes that have more faces there.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "distance/closest_point.h"
#include "plait/error.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "remesh/remesh.h"
#include "remesh_files.h"
#include "support/error_of.h"
#include "support/real_meshes.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

/// A sheet with fins across it, each a few edges high and thinner than an edge.
IndexedMesh finned_sheet() {
  IndexedMesh mesh = sheet(60, 60);
  for (Vector3<double>& p : mesh.positions) {
    const double across = std::abs(std::remainder(p.x + 0.37 * p.y, 17.0));
    p.z = 6 * std::exp(-across * across) + 0.3 * std::sin(0.7 * p.y);
  }
  return mesh;
}

/// No base mesh of a few faces follows this.
IndexedMesh crumpled_sheet() {
  IndexedMesh mesh = sheet(40, 40);
  std::uint32_t state = 9;
  for (Vector3<double>& p : mesh.positions) {
    state = state * 1664525 + 1013904223;
    p.z = 6 * static_cast<double>(state >> 16) / 65536;
  }
  return mesh;
}

/// How a small triangle lies to a scan that is a surface over the plane.
enum class Turn : std::uint8_t { kNo, kYes, kUnclear };

/// Knows the faces of the scan that have a point of the plane, by trying all. A point on an edge is
/// on several of them.
class FacesBelow {
 public:
  explicit FacesBelow(const IndexedMesh& scan) : scan_(scan) {}

  Turn turn_of(const std::array<Vector3<double>, 3>& corners) const {
    const Vector3<double> normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    double least = 0, most = 0;  // of dot(normal, sum of the scan's normals)
    for (const Vector3<double>& corner : corners) {
      double least_here = 1e300, most_here = -1e300;
      for (const auto& face : scan_.faces) {
        const Vector3<double> a = scan_.positions[face[0]], b = scan_.positions[face[1]],
                              c = scan_.positions[face[2]];
        const Vector3<double> full = cross(b - a, c - a);
        const auto part = [&](const Vector3<double>& p, const Vector3<double>& q) {
          return ((p.x - corner.x) * (q.y - corner.y) - (p.y - corner.y) * (q.x - corner.x)) /
                 full.z;
        };
        if (std::min({part(a, b), part(b, c), part(c, a)}) < -1e-5) continue;
        const double here = dot(normal, normalized(full));
        least_here = std::min(least_here, here);
        most_here = std::max(most_here, here);
      }
      least += least_here;
      most += most_here;
    }
    return most < -1e-7 ? Turn::kYes : least > 1e-7 ? Turn::kNo : Turn::kUnclear;
  }

 private:
  const IndexedMesh& scan_;
};

}  // namespace

TEST_CASE("Remesh_TurnedFaces_AreMarkedAtTheirCorners") {
  const RemeshFiles files;
  const IndexedMesh scan = crumpled_sheet();
  write_ply(files.scan, scan);
  RemeshRequest request = files.request(40);
  request.precision = ComponentType::kFloat64;  // float32 would turn needles
  const RemeshReport report = files.run(request);
  REQUIRE(report.turned > 0);
  CHECK(report.base_meshes == 1);
  CHECK(report.turned_before > report.turned);
  const Store store = files.open();
  const VertexNumbering numbering(store.base().topology(), 3);
  const FacesBelow faces(scan);
  std::vector<bool> marked(numbering.vertex_count()), must(marked.size()), may(marked.size());
  std::uint64_t turned = 0, unclear = 0;
  for_each_patch(store, [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<double>>("position");
    const auto marks = patch.attribute<std::uint8_t>("turned");
    for_each_triangle(3, [&](const std::array<FacePoint, 3>& points) {
      std::array<Vector3<double>, 3> corners;
      std::array<std::uint64_t, 3> numbers{};
      for (std::size_t at = 0; at < 3; ++at) {
        const FacePoint& p = points[at];
        corners[at] = position.at(p.i, p.j);
        numbers[at] = numbering.number({patch.face(), 3, p.i, p.j});
        marked[numbers[at]] = marks.at(p.i, p.j) == 1;
        CHECK(marks.at(p.i, p.j) <= 1);
      }
      const Turn turn = faces.turn_of(corners);
      turned += turn == Turn::kYes ? 1u : 0u;
      unclear += turn == Turn::kUnclear ? 1u : 0u;
      for (const std::uint64_t number : numbers) {
        if (turn == Turn::kYes) must[number] = true;
        if (turn != Turn::kNo) may[number] = true;
      }
    });
  });
  CHECK(turned <= report.turned);
  CHECK(turned + unclear >= report.turned);
  CHECK(turned > 0);
  std::size_t wrong = 0;
  for (std::size_t vertex = 0; vertex < marked.size(); ++vertex)
    wrong += (must[vertex] && !marked[vertex]) || (marked[vertex] && !may[vertex]);
  CHECK(wrong == 0);
}

TEST_CASE("Remesh_BaseMeshThatIsTheScan_IsExactAndNothingMoves") {
  // Its edges are sharp, so points on them may belong to a face that looks the other way.
  const IndexedMesh cube = {
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
      {{0, 2, 1},
       {0, 3, 2},
       {4, 5, 6},
       {4, 6, 7},
       {0, 1, 5},
       {0, 5, 4},
       {1, 2, 6},
       {1, 6, 5},
       {2, 3, 7},
       {2, 7, 6},
       {3, 0, 4},
       {3, 4, 7}}};
  for (const IndexedMesh& mesh : {cube, crumpled_sheet()}) {
    const RemeshFiles files;
    write_ply(files.scan, mesh);
    RemeshRequest request = files.request(mesh.faces.size(), 3);
    request.precision = ComponentType::kFloat64;
    const RemeshReport report = files.run(request);
    CHECK(report.base.faces == mesh.faces.size());
    CHECK(report.exact_faces == report.base.faces);
    CHECK(report.relaxed_samples == 0);
    CHECK(report.moved_samples == 0);
    CHECK(report.turned == 0);
    CHECK(report.folds == report.scan.folded_edges * 8);
    CHECK(report.to_store.max < 1e-13 * report.diagonal);
    CHECK(report.to_scan.max < 1e-13 * report.diagonal);
  }
}

// The closest points of the one sheet are on the other, so no distance shows it.
TEST_CASE("Remesh_SheetsNearerThanItsDistance_SaysThatTheyPassThroughEachOther") {
  const RemeshFiles files;
  IndexedMesh mesh = sheet(60, 60);
  for (Vector3<double>& p : mesh.positions) p.z = 3 * std::sin(0.2 * p.x) * std::cos(0.3 * p.y);
  const auto count = static_cast<VertexId>(mesh.positions.size());
  for (VertexId vertex = 0; vertex < count; ++vertex)
    mesh.positions.push_back(mesh.positions[vertex] + Vector3<double>{0, 0, 0.01});
  const std::size_t faces = mesh.faces.size();
  for (std::size_t face = 0; face < faces; ++face) {
    const auto [a, b, c] = mesh.faces[face];
    mesh.faces.push_back({a + count, c + count, b + count});
  }
  write_ply(files.scan, mesh);
  std::vector<std::string> warnings;
  const JobWatch watch{.warn = [&](const std::string& line) { warnings.push_back(line); }};
  const RemeshReport report = files.run(files.request(120, 2), watch);
  CHECK(report.scan_crossings.faces == 0);
  CHECK(report.crossings.faces > 0);
  CHECK(std::ranges::any_of(warnings, [](const std::string& line) {
    return line.find("small faces pass through others, and 0 faces of the scan") !=
           std::string::npos;
  }));
}

TEST_CASE("Remesh_Plane_IsExactToItsCorners") {
  const RemeshFiles files;
  write_ply(files.scan, flat_sheet(40, 30));
  RemeshRequest request = files.request(24, 3);
  request.precision = ComponentType::kFloat64;
  const RemeshReport report = files.run(request);
  CHECK(report.exact_faces == report.base.faces);
  CHECK(report.to_store.max < 1e-13 * report.diagonal);
  CHECK(report.to_scan.max < 1e-13 * report.diagonal);
}

TEST_CASE("Remesh_CubeOfManyFaces_IsExactToItsEdges") {
  // No axis is that of a coordinate.
  IndexedMesh cube = cube_grid(20);
  for (Vector3<double>& p : cube.positions)
    p = {0.8 * p.x - 0.6 * p.y, 0.48 * p.x + 0.64 * p.y - 0.6 * p.z,
         0.36 * p.x + 0.48 * p.y + 0.8 * p.z};
  const RemeshFiles files;
  write_ply(files.scan, cube);
  RemeshRequest request = files.request(192, 3);
  request.precision = ComponentType::kFloat64;
  request.digest = true;
  std::vector<std::string> digests;
  for (const int threads : {1, 2}) {
    request.threads = threads;
    const RemeshReport report = files.run(request);
    CHECK(report.crease_edges == 240);
    CHECK(report.crease_corners == 8);
    CHECK(report.base.faces == 192);
    CHECK(report.turned == 0);
    CHECK(report.to_store.max < 1e-7 * report.diagonal);  // the file has float32
    CHECK(report.to_scan.max < 1e-7 * report.diagonal);
    digests.push_back(report.digest);
  }
  CHECK(digests[0] == digests[1]);

  request.feature_angle = 180;
  const RemeshReport rounded = files.run(request);
  CHECK(rounded.crease_edges == 0);
  CHECK(rounded.to_store.max > 1e-4 * rounded.diagonal);
  // Fewer faces than the corners need: an angle that was asked for is kept, the default is not.
  request.feature_angle = 60;
  request.faces = 6;
  CHECK(std::string(error_of([&] { files.run(request); }).what()).find("found 12 as the fewest") !=
        std::string::npos);
  request.feature_angle.reset();
  std::vector<std::string> warnings;
  const RemeshReport few =
      files.run(request, {.warn = [&](const std::string& what) { warnings.push_back(what); }});
  CHECK(few.base.faces <= 7);
  CHECK(few.crease_edges == 0);
  CHECK(few.faces_for_creases == 12);
  REQUIRE(!warnings.empty());
  CHECK(warnings[0].find("take --faces 12") != std::string::npos);
}

TEST_CASE("Remesh_NoTurnedFacesAsked_AreGoneAfterOtherBaseMeshes") {
  const RemeshFiles files;
  write_ply(files.scan, finned_sheet());
  RemeshRequest request = files.request(300);
  request.digest = true;
  CHECK(files.run(request).turned > 0);
  request.refuse_turned = true;
  std::vector<std::string> digests;
  for (int threads = unless_sanitized(1, 2); threads <= 2; ++threads) {
    request.threads = threads;
    const RemeshReport report = files.run(request);
    CHECK(report.base_meshes > 1);
    CHECK(report.base_meshes <= 8);
    CHECK(report.turned == 0);
    CHECK(report.base.faces <= 300);
    CHECK(keeps_topology(report));
    CHECK(files.open().has_attribute("turned"));
    digests.push_back(report.digest);
  }
  CHECK(digests.front() == digests.back());
}

TEST_CASE("Remesh_NoTurnedFacesAsked_IsOneBaseMeshIfThereAreNone") {
  const RemeshFiles files;
  write_ply(files.scan, torus_grid(30, 20));
  RemeshRequest request = files.request(60);
  request.digest = true;
  const std::string digest = files.run(request).digest;
  request.refuse_turned = true;
  const RemeshReport report = files.run(request);
  CHECK(report.base_meshes == 1);
  CHECK(report.digest == digest);
}

TEST_CASE("Remesh_FacesThatStayTurned_AreRefusedWithAttemptsAndPlaces") {
  const RemeshFiles files;
  const IndexedMesh scan = crumpled_sheet();
  write_ply(files.scan, scan);
  RemeshRequest request = files.request(40);
  request.refuse_turned = true;
  const Error error = error_of([&] { files.run(request); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  const std::string text = error.what();
  CHECK(text.find("the last of 8 base meshes, at (") != std::string::npos);
  CHECK(!std::filesystem::exists(files.store));
  // The places are points of the scan.
  const TriangleTree tree(scan.positions, scan.faces);
  std::size_t places = 0;
  for (std::size_t at = text.find(" at (") + 4; at < text.size() && text[at] == '(';) {
    char* end = nullptr;
    Vector3<double> place;
    place.x = std::strtod(text.c_str() + at + 1, &end);
    place.y = std::strtod(end + 1, &end);
    place.z = std::strtod(end + 1, &end);
    CHECK(tree.closest(place).squared_distance < 1e-8);
    ++places;
    at = static_cast<std::size_t>(end - text.c_str()) + 3;  // after "), "
  }
  CHECK(places == 3);
}

TEST_CASE("Remesh_ProgressOverBaseMeshesAndAttributes_NeverFalls") {
  const RemeshFiles files;
  write_with_attributes(files.scan, finned_sheet());
  RemeshRequest request = files.request(200);
  request.distances = true;
  for (const bool refuse_turned : {true, false}) {
    request.refuse_turned = refuse_turned;
    std::uint64_t before = 0, rises = 0, falls = 0, calls = 0, base_meshes = 0;
    std::string phase;
    const RemeshReport report = files.run(request, {.progress = [&](const Progress& now) {
                                            ++calls;
                                            rises += now.done > before;
                                            falls += now.done < before || now.done > now.total;
                                            before = now.done;
                                            base_meshes += now.phase == "relax" && phase != "relax";
                                            phase = now.phase;
                                            CHECK(now.total == 1000);
                                            return true;
                                          }});
    CHECK(falls == 0);
    CHECK(calls > 20);
    CHECK(rises > 20);
    CHECK(before == 1000);
    CHECK(base_meshes == report.base_meshes);
    CHECK((report.base_meshes > 1) == refuse_turned);
    CHECK((report.turned > 0) == !refuse_turned);
  }
}

TEST_CASE("Remesh_RealScanWithHoles_HasNoTurnedFacesIfAsked") {
  // A sanitizer finds no more in a mesh that is larger.
  if (!unless_sanitized(has_real_mesh("bunny_open"), false)) return;
  const RemeshFiles files;
  RemeshRequest request = files.request(694);
  request.scan = real_mesh_path("bunny_open");
  request.report_samples = 50000;
  request.refuse_turned = true;
  const RemeshReport report = files.run(request);
  CHECK(report.base_meshes > 1);
  CHECK(report.turned == 0);
  CHECK(keeps_topology(report));
  CHECK(100 * report.to_store.rms < 0.020 * report.diagonal);
}

}  // namespace plait::test
