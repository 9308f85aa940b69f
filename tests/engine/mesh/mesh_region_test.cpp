// What the slots of a range of edges follow from: found as by hand, in each mesh.
#include "mesh/mesh_region.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "support/test_meshes.h"

namespace plait::test {
namespace {

/// By looks at all faces.
MeshRegion naive_region(const BaseMesh& mesh, EdgeId first, EdgeId after) {
  const Topology topology = mesh.topology();
  std::set<FaceId> faces;
  std::set<VertexId> vertices, neighbours;
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (const EdgeId edge : topology.face_edges[face])
      if (edge >= first && edge < after) faces.insert(face);
  for (const FaceId face : faces)
    vertices.insert(topology.faces[face].begin(), topology.faces[face].end());
  for (const auto& corners : topology.faces)
    if (std::ranges::any_of(corners, [&](VertexId vertex) { return vertices.contains(vertex); }))
      neighbours.insert(corners.begin(), corners.end());
  std::vector<FaceId> around;
  for (FaceId face = 0; face < topology.faces.size(); ++face)
    if (!faces.contains(face) && std::ranges::any_of(topology.faces[face], [&](VertexId vertex) {
          return vertices.contains(vertex);
        }))
      around.push_back(face);
  return {{faces.begin(), faces.end()},
          {vertices.begin(), vertices.end()},
          {neighbours.begin(), neighbours.end()},
          around};
}

void check_region(const BaseMesh& mesh, EdgeId first, EdgeId after) {
  CAPTURE(first, after);
  const BaseMesh part = mesh.around(first, after);
  const MeshRegion expected = naive_region(mesh, first, after);
  CHECK(part.region()->faces == expected.faces);
  CHECK(part.region()->vertices == expected.vertices);
  CHECK(part.region()->neighbours == expected.neighbours);
  CHECK(part.region()->faces_around == expected.faces_around);
}

}  // namespace

TEST_CASE("MeshRegion_OfAnyEdges_IsWhatLooksAtAllFacesFind") {
  std::mt19937 random(41);
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    const auto edges = static_cast<EdgeId>(mesh.edge_count());
    CHECK(mesh.region() == nullptr);
    check_region(mesh, 0, edges);
    check_region(mesh, edges - 1, edges);
    for (int i = 0; i < 12; ++i) {
      const auto first = static_cast<EdgeId>(random() % edges);
      check_region(mesh, first, static_cast<EdgeId>(first + 1 + random() % (edges - first)));
    }
  }
}

TEST_CASE("MeshRegion_OfFacesInRandomOrder_IsWhatLooksAtAllFacesFind") {
  std::mt19937 random(42);
  const BaseMesh in_order = BaseMesh::build(side_by_side({torus_grid(12, 9), sheet(8, 8)}));
  std::vector<FaceId> order(in_order.face_count());
  for (FaceId face = 0; face < order.size(); ++face) order[face] = face;
  std::ranges::shuffle(order, random);
  const BaseMesh mesh = in_order.with_face_order(order);
  const auto edges = static_cast<EdgeId>(mesh.edge_count());
  for (EdgeId first = 0; first < edges; first += 11)
    for (const EdgeId length : {1u, 7u, 60u})
      check_region(mesh, first, std::min(edges, first + length));
}

}  // namespace plait::test
