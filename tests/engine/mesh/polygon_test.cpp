// Polygons that a fan around their first corner does not fill, and the numbers of the faces that
// are cut into triangles.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "mesh_files.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using shapes::refusal;

namespace {

using Corners = std::vector<Vector3<double>>;

std::string obj_of(const Corners& corners, const std::vector<std::size_t>& polygon) {
  std::string text;
  for (const Vector3<double>& p : corners) text += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  text += "f";
  for (const std::size_t corner : polygon) text += fmt::format(" {}", corner + 1);
  return text + "\n";
}

std::vector<std::size_t> in_order(std::size_t count, std::size_t first) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < count; ++i) order.push_back((first + i) % count);
  return order;
}

IndexedMesh read_polygons(const std::string& name, const std::string& bytes,
                          std::vector<std::string>* warnings = nullptr) {
  const MeshDirectory directory;
  return read_indexed_mesh(directory.file(name, bytes), warnings);
}

Vector3<double> area_vector(const IndexedMesh& mesh, const std::array<VertexId, 3>& face) {
  const Vector3<double>& a = mesh.positions[face[0]];
  return 0.5 * cross(mesh.positions[face[1]] - a, mesh.positions[face[2]] - a);
}

/// The sum of the areas of the triangles, each of which must have the side of `normal`.
double area_on_side(const IndexedMesh& mesh, const Vector3<double>& normal) {
  double sum = 0;
  for (const auto& face : mesh.faces) {
    const Vector3<double> area = area_vector(mesh, face);
    CHECK(dot(area, normal) > 0);
    sum += std::sqrt(dot(area, area));
  }
  return sum;
}

/// A square of 4 x 4 with a notch: 14 of its 16 units are left.
const Corners kNotched = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 3, 0}, {0, 4, 0}};

Corners turned_up(Corners corners) {  // into the plane x = z, and far away
  for (Vector3<double>& p : corners) p = {p.x + 400000, p.y + 5400000, p.x - 7};
  return corners;
}

}  // namespace

TEST_CASE("ReadPolygon_NotConvex_IsFilledFromEveryFirstCorner") {
  for (std::size_t first = 0; first < kNotched.size(); ++first) {
    INFO(first);
    const auto order = in_order(kNotched.size(), first);
    const IndexedMesh flat = read_polygons("a.obj", obj_of(kNotched, order));
    CHECK(flat.faces.size() == 3);
    CHECK(area_on_side(flat, {0, 0, 1}) == Approx(14));
    const IndexedMesh far = read_polygons("a.obj", obj_of(turned_up(kNotched), order));
    CHECK(area_on_side(far, {-1, 0, 1}) == Approx(14 * std::sqrt(2.0)));
    const std::vector<std::size_t> back(order.rbegin(), order.rend());
    CHECK(area_on_side(read_polygons("a.obj", obj_of(kNotched, back)), {0, 0, -1}) == Approx(14));
  }
}

TEST_CASE("ReadPolygon_Comb_IsFilled") {
  Corners comb = {{0, -1, 0}};
  for (int tooth = 0; tooth < 50; ++tooth) {
    comb.push_back({2.0 * tooth + 1, -1, 0});
    comb.push_back({2.0 * tooth + 1, 3, 0});
    comb.push_back({2.0 * tooth + 1.25, 0, 0});
  }
  comb.push_back({101, -1, 0});
  comb.push_back({101, -2, 0});
  comb.push_back({0, -2, 0});
  const IndexedMesh mesh = read_polygons("a.obj", obj_of(comb, in_order(comb.size(), 0)));
  double wanted = 0;
  for (std::size_t i = 0; i < comb.size(); ++i) {
    const auto &a = comb[i], &b = comb[(i + 1) % comb.size()];
    wanted += 0.5 * (a.x * b.y - a.y * b.x);
  }
  CHECK(mesh.faces.size() == comb.size() - 2);
  CHECK(area_on_side(mesh, {0, 0, wanted}) == Approx(std::abs(wanted)));
}

TEST_CASE("ReadPolygon_CornersOnALine_GiveNoTriangleWithoutArea") {
  const Corners square = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}};
  for (std::size_t first = 0; first < square.size(); ++first)
    CHECK(area_on_side(read_polygons("a.obj", obj_of(square, in_order(square.size(), first))),
                       {0, 0, 1}) == Approx(4));
}

TEST_CASE("ReadPolygon_HoleOnABridge_IsLeftOpen") {
  const Corners corners = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0},
                           {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}};
  const IndexedMesh mesh = read_polygons("a.obj", obj_of(corners, {0, 1, 2, 3, 0, 4, 5, 6, 7, 4}));
  CHECK(mesh.faces.size() == 8);
  CHECK(area_on_side(mesh, {0, 0, 1}) == Approx(12));
  CHECK(BaseMesh::build(mesh).border_edge_count() == 8);
}

TEST_CASE("ReadPolygon_Convex_StaysAFan") {
  std::vector<std::string> warnings;
  const IndexedMesh mesh = read_polygons(
      "a.obj", obj_of({{0, 0, 0}, {2, 0, 0}, {3, 2, 0.1}, {1, 3, 0}, {-1, 1, 0}}, {0, 1, 2, 3, 4}),
      &warnings);
  CHECK(mesh.faces == shapes::Faces{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("1 faces of more than three corners divided into triangles") &&
                              !Contains("ears"));
}

TEST_CASE("ReadPolygon_Divided_SaysHowMany") {
  std::vector<std::string> warnings;
  read_polygons("a.obj", obj_of(kNotched, in_order(5, 2)) + "f 1 2 3 4\n", &warnings);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("2 faces") && Contains("1 of them, which are not convex"));
}

TEST_CASE("ReadPolygon_SidesThatCross_AreRefusedWithTheFace") {
  const Corners bow = {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {9, 9, 9}};
  const std::string first = "f 1 2 5\n";
  CHECK_THAT(refusal([&] {
               read_polygons("a.obj", obj_of(bow, {0, 1, 2, 3}) + first);
             }),
             Contains("face 1: expected a polygon that triangles can fill") &&
                 Contains("4 corners whose sides cross"));
  CHECK_THAT(refusal([&] {
               read_polygons("a.off",
                             "OFF\n4 2 0\n0 0 0\n2 2 0\n2 0 0\n0 3 0\n3 0 1 2\n4 0 1 2 3\n");
             }),
             Contains("face 1: expected a polygon") && Contains("whose sides 0 and 2 cross"));
  // A pentagram goes around twice.
  Corners star;
  for (int i = 0; i < 5; ++i)
    star.push_back(
        {std::cos(4 * i * 3.14159265358979 / 5), std::sin(4 * i * 3.14159265358979 / 5), 0});
  CHECK_THAT(refusal([&] { read_polygons("a.obj", obj_of(star, in_order(5, 0))); }),
             Contains("cross"));
}

TEST_CASE("ReadPolygon_CornerTwiceInARow_IsLeftToTheMesh") {
  const std::string bytes = obj_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 2});
  CHECK(read_polygons("a.obj", bytes).faces == shapes::Faces{{0, 1, 2}, {0, 2, 2}});
  const MeshDirectory directory;
  CHECK_THAT(refusal([&] { read_base_mesh(directory.file("a.obj", bytes)); }),
             Contains("face 0: expected three different vertices"));
}

TEST_CASE("ReadPolygon_TwoCornersAtOnePlace_HasOneTriangleWithoutArea") {
  // A quadrilateral at the pole of a sphere of longitudes and latitudes.
  const Corners pole = {{0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  for (std::size_t first = 0; first < pole.size(); ++first) {
    const IndexedMesh mesh = read_polygons("a.obj", obj_of(pole, in_order(pole.size(), first)));
    REQUIRE(mesh.faces.size() == 2);
    const Vector3<double> sum = area_vector(mesh, mesh.faces[0]) + area_vector(mesh, mesh.faces[1]);
    CHECK(std::sqrt(dot(sum, sum)) == Approx(std::sqrt(3.0) / 2));
  }
}

TEST_CASE("ReadBaseMesh_PolygonMesh_NamesFacesOfTheFile") {
  const MeshDirectory directory;
  // Two squares, a triangle, and a pentagon that has the edge 1-2 again, which is the third time.
  const std::string bytes =
      "OFF\n9 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n2 1 0\n1 2 0\n1 0 1\n1 1 1\n"
      "4 0 1 2 3\n4 1 4 5 2\n3 2 6 3\n4 1 7 8 2\n";
  CHECK_THAT(refusal([&] { read_base_mesh(directory.file("a.off", bytes)); }),
             Contains("edge 1-2: expected at most two faces, found 3: faces 0, 1, 3") &&
                 Contains("plait check") && Contains("plait remesh"));
}
