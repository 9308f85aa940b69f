// Twins and plain fans, beside their definitions: two sides are twins if they are the only ones
// between their two vertices.
#include <catch2/catch.hpp>
#include <map>
#include <utility>

#include "mesh/connectivity.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using Ends = std::pair<VertexId, VertexId>;

std::map<Ends, std::vector<FaceSide>> sides_between(const IndexedMesh& mesh) {
  std::map<Ends, std::vector<FaceSide>> sides;
  for (FaceId face = 0; face < mesh.faces.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      const VertexId one = mesh.faces[face][static_cast<std::size_t>((side + 1) % 3)],
                     two = mesh.faces[face][static_cast<std::size_t>((side + 2) % 3)];
      sides[std::minmax(one, two)].emplace_back(face, side);
    }
  return sides;
}

MatchedSides matched(const IndexedMesh& mesh) {
  return match_sides(mesh.faces, mesh.positions.size(), "mesh");
}

/// How many sides have another twin than the definition says.
std::size_t wrong_twins(const IndexedMesh& mesh, const MatchedSides& found) {
  std::size_t wrong = 0;
  const auto twin = [&](FaceSide side) {
    return from_code(found.twins[side.face()][static_cast<std::size_t>(side.side())]);
  };
  for (const auto& [ends, sides] : sides_between(mesh)) {
    REQUIRE(sides.size() <= 2);
    wrong += twin(sides.front()) != (sides.size() == 2 ? sides.back() : FaceSide());
    wrong += twin(sides.back()) != (sides.size() == 2 ? sides.front() : FaceSide());
  }
  return wrong;
}

}  // namespace

TEST_CASE("MatchSides_ShuffledMeshes_AreThoseOfTheDefinition") {
  // The definition compares each vertex with each face.
  constexpr unsigned kVertices = unless_sanitized(3000u, 600u);
  std::vector<IndexedMesh> meshes = {bipyramid(32),
                                     bipyramid(33),
                                     bipyramid(500),
                                     open_fan(32),
                                     open_fan(33),
                                     closed_fan(33),
                                     random_sphere(5, kVertices),
                                     random_sheet(6, kVertices)};
  for (const NamedMesh& each : all_meshes()) meshes.push_back(each.mesh);
  unsigned seed = 0;
  for (const IndexedMesh& ordered : meshes) {
    const IndexedMesh mesh = shuffled(ordered, ++seed);
    INFO("mesh " << seed);
    const MatchedSides found = matched(mesh);
    CHECK(found.oriented);
    CHECK(wrong_twins(mesh, found) == 0);
    std::uint64_t border_edges = 0;
    for (const auto& [ends, sides] : sides_between(mesh)) border_edges += sides.size() == 1;
    CHECK(found.border_count == border_edges);
    CHECK(found.has_plain_fans == without_plain_fan(mesh.faces, mesh.positions.size()).empty());
  }
  CHECK(matched(bipyramid(32)).has_plain_fans);
  CHECK_FALSE(matched(bipyramid(33)).has_plain_fans);
}

TEST_CASE("MatchSides_TurnedFace_IsNotOriented") {
  IndexedMesh mesh = shuffled(random_sphere(3, 500), 4);
  std::swap(mesh.faces[70][0], mesh.faces[70][1]);
  const MatchedSides found = matched(mesh);
  CHECK_FALSE(found.oriented);
  CHECK_FALSE(found.has_plain_fans);
  CHECK(wrong_twins(mesh, found) == 0);
}

TEST_CASE("WithoutPlainFan_Vertices_AreThoseThatNameNoEdges") {
  // Two tetrahedra that meet in vertex 0.
  IndexedMesh mesh = tetrahedron();
  for (std::array<VertexId, 3> face : tetrahedron().faces) {
    for (VertexId& vertex : face) vertex = vertex == 0 ? 0 : vertex + 3;
    mesh.faces.push_back(face);
  }
  CHECK(without_plain_fan(mesh.faces, 8) == std::vector<VertexId>{0});
  // A closed fan of two faces, whose vertices have their neighbours once.
  CHECK(without_plain_fan(two_faces_back_to_back().faces, 3).empty());
  // Four faces around 0 and 1, with two edges between them.
  const std::vector<FaceVertices> twice = {{0, 1, 2}, {1, 0, 3}, {0, 1, 3}, {1, 0, 2}};
  CHECK(without_plain_fan(twice, 4) == std::vector<VertexId>{0, 1});
  // A face that has a vertex twice.
  CHECK(without_plain_fan(std::vector<FaceVertices>{{4, 4, 2}}, 6) == std::vector<VertexId>{4});
}
