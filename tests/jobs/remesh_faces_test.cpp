// What a file says about the faces of a scan comes along, as attributes of the base faces.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "plait/notes.h"
#include "plait/reader.h"
#include "remesh/remesh.h"
#include "remesh_files.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

Vector3<double> middle_of(const IndexedMesh& mesh, const std::array<VertexId, 3>& face) {
  return (1.0 / 3) * (mesh.positions[face[0]] + mesh.positions[face[1]] + mesh.positions[face[2]]);
}

/// A PLY file whose faces have what `text_of` says of their middles.
void write_with_faces(const std::filesystem::path& path, const IndexedMesh& mesh,
                      const std::string& properties,
                      const std::function<std::string(const Vector3<double>&)>& text_of) {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face "
       << mesh.faces.size() << "\nproperty list uchar int vertex_indices\n"
       << properties << "end_header\n";
  for (const Vector3<double>& p : mesh.positions) file << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const auto& face : mesh.faces)
    file << "3 " << face[0] << ' ' << face[1] << ' ' << face[2] << ' '
         << text_of(middle_of(mesh, face)) << '\n';
}

/// The part of a triangle's area where x < at. REQUIRES: z = 0.
double share_left_of(std::array<Vector3<double>, 3> corners, double at) {
  std::ranges::sort(corners, {}, [](const Vector3<double>& p) { return p.x; });
  const auto [a, b, c] = corners;
  if (at <= a.x) return 0;
  if (at >= c.x) return 1;
  if (at <= b.x) return (at - a.x) * (at - a.x) / ((b.x - a.x) * (c.x - a.x));
  return 1 - (c.x - at) * (c.x - at) / ((c.x - b.x) * (c.x - a.x));
}

std::array<Vector3<double>, 3> corners_of(const Store& store, FaceId face) {
  std::array<Vector3<double>, 3> corners;
  for (std::size_t at = 0; at < 3; ++at)
    corners[at] = store.base().positions()[store.base().faces()[face][at]];
  return corners;
}

}  // namespace

TEST_CASE("Remesh_PropertiesOfFaces_AreTheLargestPartAndTheMean") {
  const RemeshFiles files;
  // The small faces of a base face are as large as each other: none of them moves on a plane.
  write_with_faces(files.scan, flat_sheet(40, 40),
                   "property int label\nproperty double height\nproperty float weight\nproperty "
                   "uchar red\nproperty list uchar int near\nproperty char bad.name\n",
                   [](const Vector3<double>& p) {
                     return std::string(p.x < 20 ? "-1 0 0.1 0" : "2 8 0.1 100") + " 2 7 7 3";
                   });
  std::vector<std::string> warnings;
  RemeshRequest request = files.request(60, 5);
  const RemeshReport report =
      files.run(request, {.warn = [&](const std::string& what) { warnings.push_back(what); }});
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("left out: properties near, bad.name of 3200 faces"));
  REQUIRE(report.face_attributes.size() == 4);
  CHECK(report.face_attributes[0] == AttributeSchema{"label", ComponentType::kInt32, 1});
  CHECK(report.face_attributes[1] == AttributeSchema{"height", ComponentType::kFloat64, 1});
  const Store store = files.open();
  const auto label = store.notes().face_records<std::int32_t>("label");
  const auto height = store.notes().face_records<double>("height");
  const auto weight = store.notes().face_records<float>("weight");
  const auto red = store.notes().face_records<std::uint8_t>("red");
  std::uint64_t mixed = 0;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    CAPTURE(face);
    const double left = share_left_of(corners_of(store, face), 20);
    CHECK(height[face] == Approx(8 * (1 - left)).margin(0.15));
    CHECK(std::abs(red[face] - 100 * (1 - left)) < 2.5);
    CHECK(weight[face] == 0.1f);
    if (std::abs(left - 0.5) > 0.02) CHECK(label[face] == (left > 0.5 ? -1 : 2));
    mixed += left > 0 && left < 1 && height[face] > 0 && height[face] < 8 ? 1u : 0u;
  }
  CHECK(mixed > 4);
  CHECK(report.mixed_faces == std::vector<std::uint64_t>{mixed, mixed, 0, mixed});
}

TEST_CASE("Remesh_BaseMeshThatIsTheScan_KeepsTheNumberOfEachFace") {
  const RemeshFiles files;
  const IndexedMesh cube = cube_grid(2);
  write_with_faces(files.scan, cube, "property ushort place\n", [](const Vector3<double>& p) {
    return std::to_string(std::lround(100 * (p.x + 2 * p.y + 3 * p.z) + 1000));
  });
  const RemeshReport report = files.run(files.request(cube.faces.size(), 1));
  REQUIRE(report.base.faces == cube.faces.size());
  const Store store = files.open();
  const auto place = store.notes().face_records<std::uint16_t>("place");
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const auto [a, b, c] = corners_of(store, face);
    const Vector3<double> p = (1.0 / 3) * (a + b + c);
    CHECK(place[face] == std::lround(100 * (p.x + 2 * p.y + 3 * p.z) + 1000));
  }
  CHECK(report.mixed_faces == std::vector<std::uint64_t>{0});
}

TEST_CASE("Remesh_FilledHole_HasTheNumberOfTheNearestFace") {
  IndexedMesh mesh = flat_sheet(12, 12);
  std::erase_if(mesh.faces, [&](const auto& face) {
    const Vector3<double> p = middle_of(mesh, face);
    return p.x > 2 && p.x < 10 && p.y > 2 && p.y < 10;
  });
  const RemeshFiles files;
  write_with_faces(files.scan, mesh, "property uchar side\n",
                   [](const Vector3<double>& p) { return std::string(p.x < 6 ? "5" : "6"); });
  RemeshRequest request = files.request(40);
  request.repair.fill_holes = 40;
  const RemeshReport report = files.run(request);
  CHECK(report.repairs.filled_holes == 1);
  const Store store = files.open();
  const auto side = store.notes().face_records<std::uint8_t>("side");
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const double left = share_left_of(corners_of(store, face), 6);
    if (left < 0.3 || left > 0.7) CHECK(side[face] == (left > 0.5 ? 5 : 6));
  }
}

TEST_CASE("Remesh_RemovedAndCutFaces_LeaveTheOthersTheirNumbers") {
  const RemeshFiles files;
  // A square and a triangle, after a face without area and one given twice.
  std::ofstream(files.scan)
      << "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
         "float z\nelement face 4\nproperty short mark\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n"
         "11 3 0 0 1\n12 4 0 1 2 3\n13 3 1 4 2\n14 3 4 2 1\n";
  const RemeshReport report = files.run(files.request(3, 1));
  CHECK(report.repairs.degenerate_faces == 1);
  CHECK(report.repairs.duplicate_faces == 1);
  REQUIRE(report.base.faces == 3);
  const Store store = files.open();
  const auto mark = store.notes().face_records<std::int16_t>("mark");
  for (FaceId face = 0; face < 3; ++face)
    CHECK(mark[face] == (share_left_of(corners_of(store, face), 1) > 0.5 ? 12 : 13));
}

TEST_CASE("Remesh_PropertiesOfFaces_AreTheSameForAnyNumberOfThreadsAndWithDepths") {
  const RemeshFiles files;
  write_with_faces(files.scan, with_noise(torus_grid(60, 40), 0.01),
                   "property float quality\nproperty uint part\n", [](const Vector3<double>& p) {
                     return std::to_string(p.x * p.y) + ' ' + std::to_string(p.z > 0 ? 7 : 9);
                   });
  std::vector<std::vector<std::byte>> found;
  for (const bool depths : {false, true})
    for (const int threads : {1, 3}) {
      RemeshRequest request = files.request(200, 2);
      request.threads = threads;
      if (depths) request.max_distance = RelativeLength{1};
      files.run(request);
      const Store store = files.open();
      std::vector<std::byte> bytes;
      for (const char* name : {"quality", "part"})
        std::ranges::copy(store.notes().face_bytes(name), std::back_inserter(bytes));
      found.push_back(std::move(bytes));
    }
  CHECK(!found[0].empty());
  CHECK(found[1] == found[0]);
  CHECK(found[3] == found[2]);
  CHECK(!found[2].empty());
}

TEST_CASE("Remesh_PropertyOfFacesThatIsNoNumber_SaysHowMany") {
  const RemeshFiles files;
  write_with_faces(
      files.scan, flat_sheet(10, 10), "property float heat\n",
      [](const Vector3<double>& p) { return std::string(p.x < 1 && p.y < 1 ? "nan" : "3"); });
  std::vector<std::string> warnings;
  const RemeshReport report = files.run(
      files.request(20), {.warn = [&](const std::string& what) { warnings.push_back(what); }});
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("2 faces of the scan have a value of 'heat' that is"));
  const Store store = files.open();
  std::uint64_t none = 0;
  for (const float heat : store.notes().face_records<float>("heat")) {
    none += std::isnan(heat) ? 1u : 0u;
    if (!std::isnan(heat)) CHECK(heat == 3);
  }
  CHECK(none > 0);
  CHECK(none < 10);
}

}  // namespace plait::test
