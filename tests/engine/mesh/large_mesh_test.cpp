// Meshes large enough to be built in many parts at the same time. The mesh, or the error, must be
// the same as from one loop over all parts.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <utility>

#include "plait/base_mesh.h"
#include "plait/error.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

IndexedMesh large_sheet() { return sheet(200, 200); }

std::string mesh_refusal(const IndexedMesh& mesh) {
  try {
    BaseMesh::build(mesh);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "none";
}

/// Checks the edges: numbers them by first use with a map.
void check_edges(const BaseMesh& mesh) {
  std::map<std::pair<VertexId, VertexId>, EdgeId> numbers;
  std::map<std::pair<VertexId, VertexId>, FaceSide> half_edges;
  bool right = true;
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (const int side : {2, 0, 1}) {
      const auto& corners = mesh.faces()[face];
      const VertexId start = corners[static_cast<std::size_t>((side + 1) % 3)];
      const VertexId end = corners[static_cast<std::size_t>((side + 2) % 3)];
      half_edges[{start, end}] = FaceSide(face, side);
      const auto number =
          numbers.try_emplace(std::minmax(start, end), static_cast<EdgeId>(numbers.size())).first;
      right &= mesh.face_edges()[face][static_cast<std::size_t>(side)] == number->second;
    }
  REQUIRE(mesh.edge_count() == numbers.size());
  std::vector<EdgeId> borders;
  for (const auto& [ends, number] : numbers) {
    const auto up = half_edges.find(ends), down = half_edges.find({ends.second, ends.first});
    const bool border = up == half_edges.end() || down == half_edges.end();
    const Edge& edge = mesh.edges()[number];
    const bool runs_down = up == half_edges.end();
    right &= edge.start == (runs_down ? ends.second : ends.first);
    right &= edge.end == (runs_down ? ends.first : ends.second);
    right &= edge.own == (runs_down ? down : up)->second;
    right &= edge.other == (border ? FaceSide() : down->second);
    if (border) borders.push_back(number);
  }
  CHECK(right);
  std::ranges::sort(borders);
  CHECK(std::ranges::equal(borders, mesh.border_edges()));
}

/// Checks that the corner of every vertex is the one that Topology promises.
void check_corners(const BaseMesh& mesh) {
  const Topology topology = mesh.topology();
  std::vector<FaceSide> expected(mesh.vertex_count());
  std::vector<VertexId> smallest(mesh.vertex_count(), kNoId);
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner) {
      const VertexId vertex = mesh.faces()[face][static_cast<std::size_t>(corner)];
      const VertexId next = mesh.faces()[face][static_cast<std::size_t>((corner + 1) % 3)];
      const bool border = !topology.across(FaceSide(face, (corner + 2) % 3)).exists();
      const VertexId rank = border ? 0 : next + 1;
      if (rank >= smallest[vertex]) continue;
      smallest[vertex] = rank;
      expected[vertex] = FaceSide(face, corner);
    }
  CHECK(std::ranges::equal(expected, topology.vertex_corners));
}

}  // namespace

TEST_CASE("BaseMeshBuild_LargeMesh_NumbersEdgesByFirstUse") {
  const BaseMesh mesh = BaseMesh::build(large_sheet());
  check_edges(mesh);
  check_corners(mesh);
}

TEST_CASE("BaseMeshWithFaceOrder_LargeMesh_NumbersEdgesByFirstUse") {
  const BaseMesh mesh = BaseMesh::build(large_sheet());
  std::vector<FaceId> order(mesh.face_count());
  std::iota(order.begin(), order.end(), FaceId{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  const BaseMesh moved = mesh.with_face_order(order);
  check_edges(moved);
  bool same = true;
  for (FaceId face = 0; face < order.size(); ++face)
    same &= moved.faces()[face] == mesh.faces()[order[face]];
  for (VertexId vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    const FaceSide before = mesh.topology().vertex_corners[vertex];
    const FaceSide after = moved.topology().vertex_corners[vertex];
    same &= order[after.face()] == before.face() && after.side() == before.side();
  }
  CHECK(same);
}

TEST_CASE("BaseMeshBuild_SeveralBadElementsFarApart_NamesTheFirst") {
  const std::string first =
      GENERATE("vertex 17000:", "face 17000: expected vertices", "face 17000: expected three");
  IndexedMesh mesh = large_sheet();
  for (const std::size_t at : {17000u, 36000u}) {
    if (first.starts_with("vertex"))
      mesh.positions[at].y = std::numeric_limits<double>::infinity();
    else if (first.ends_with("three"))
      mesh.faces[at][1] = mesh.faces[at][0];
    else
      mesh.faces[at][2] = static_cast<VertexId>(mesh.positions.size());
  }
  CHECK_THAT(mesh_refusal(mesh), Catch::Contains(first));
}

TEST_CASE("BaseMeshBuild_SeveralEdgesOfThreeFaces_NamesThatOfTheLowestVertex") {
  IndexedMesh mesh = large_sheet();
  const std::size_t faces = mesh.faces.size();
  for (const std::size_t face : {faces - 900, faces / 2}) {
    const auto [a, b, c] = mesh.faces[face];
    mesh.positions.push_back({0, 0, 9});
    mesh.faces.push_back({a, b, static_cast<VertexId>(mesh.positions.size() - 1)});
  }
  const auto& [a, b, c] = mesh.faces[faces / 2];
  CHECK_THAT(mesh_refusal(mesh), Catch::Contains("edge " + std::to_string(std::min(a, b)) + "-" +
                                                 std::to_string(std::max(a, b)) + ":"));
}

TEST_CASE("BaseMeshBuild_SeveralVerticesOfTwoFans_NamesTheFirst") {
  IndexedMesh mesh = large_sheet();
  for (const VertexId vertex : {39000u, 18000u}) {
    const auto next = static_cast<VertexId>(mesh.positions.size());
    mesh.positions.push_back({0, 0, 8});
    mesh.positions.push_back({0, 1, 8});
    mesh.faces.push_back({vertex, next, next + 1});
  }
  CHECK_THAT(mesh_refusal(mesh), Catch::Contains("vertex 18000:"));
}
