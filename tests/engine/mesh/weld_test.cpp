// Vertices at equal places, and what becomes of them.
#include "mesh/weld.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numeric>

#include "shapes.h"

using namespace plait;
using Catch::Contains;

namespace {

/// Each face has vertices of its own.
AttributedMesh soup(const IndexedMesh& mesh, double shift = 0) {
  AttributedMesh result;
  for (const auto& face : mesh.faces) {
    const auto first = static_cast<VertexId>(result.mesh.positions.size());
    result.mesh.faces.push_back({first, first + 1, first + 2});
    for (const VertexId vertex : face) {
      Vector3<double> p = mesh.positions[vertex];
      p.x += shift * static_cast<double>(result.mesh.positions.size() % 7);
      result.mesh.positions.push_back(p);
    }
  }
  return result;
}

std::vector<VertexId> all(std::size_t count) {
  std::vector<VertexId> vertices(count);
  std::iota(vertices.begin(), vertices.end(), VertexId{0});
  return vertices;
}

}  // namespace

TEST_CASE("Weld_TriangleSoup_BecomesAClosedSurface") {
  AttributedMesh read = soup(shapes::octahedron());
  CHECK(coinciding_vertices(read.mesh.positions, all(24)) == 24);
  std::vector<std::string> warnings;
  CHECK(weld(read, 0, "soup", warnings) == 18);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("soup: 18 vertices became others of the same position"));
  CHECK(read.mesh.positions.size() == 6);
  CHECK(coinciding_vertices(read.mesh.positions, all(6)) == 0);
  CHECK(BaseMesh::build(read.mesh).border_edge_count() == 0);
}

TEST_CASE("Weld_Tolerance_MergesWhatIsWithinIt") {
  AttributedMesh read = soup(shapes::octahedron(), 1e-6);
  std::vector<std::string> warnings;
  CHECK(weld(read, 0, "soup", warnings) < 18);
  read = soup(shapes::octahedron(), 1e-6);
  CHECK(weld(read, 1e-5, "soup", warnings) == 18);
  CHECK(BaseMesh::build(read.mesh).border_edge_count() == 0);
  // At the bound, across cells, and never through a vertex that went itself.
  AttributedMesh line{
      .mesh = {
          .positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {-0.5, 0, 0}, {1e18, 0, 0}, {1e18, 0, 0}},
          .faces = {{0, 1, 2}, {3, 4, 5}}}};
  CHECK(weld(line, 1, "line", warnings) == 3);
  CHECK(line.mesh.positions == std::vector<Vector3<double>>{{0, 0, 0}, {2, 0, 0}, {1e18, 0, 0}});
  CHECK(line.mesh.faces == shapes::Faces{{0, 0, 1}, {0, 2, 2}});
  CHECK_THAT(shapes::refusal([&] { weld(line, -1, "line", warnings); }),
             Contains("a tolerance of 0 or more"));
}

TEST_CASE("Weld_OtherAttributes_AreCountedAndThoseOfTheFirstStay") {
  AttributedMesh read = soup(shapes::tetrahedron());
  MeshAttribute texture{{"texture", ComponentType::kUint8, 1}, {}};
  for (int i = 0; i < 12; ++i) texture.records.push_back(static_cast<std::byte>(i < 3 ? i : 9));
  read.attributes = {texture};
  std::vector<std::string> warnings;
  CHECK(weld(read, 0, "soup", warnings) == 8);
  REQUIRE(warnings.size() == 2);
  CHECK_THAT(warnings[1], Contains("attribute 'texture': 6 of the vertices"));
  CHECK(read.attributes[0].records ==
        std::vector<std::byte>{std::byte{0}, std::byte{1}, std::byte{2}, std::byte{9}});
}

TEST_CASE("Weld_ZerosOfBothSignsAndNoNumbers_AreEqualAndStay") {
  AttributedMesh read{.mesh = {.positions = {{0, 0, 0}, {-0.0, 0, -0.0}, {NAN, 0, 0}, {NAN, 0, 0}},
                               .faces = {{0, 2, 3}, {1, 2, 3}}}};
  std::vector<std::string> warnings;
  CHECK(coinciding_vertices(read.mesh.positions, all(4)) == 2);
  CHECK(weld(read, 0, "a", warnings) == 1);
  CHECK(read.mesh.faces == shapes::Faces{{0, 1, 2}, {0, 1, 2}});
}
