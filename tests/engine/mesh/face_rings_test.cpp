#include "mesh/face_rings.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <set>
#include <vector>

#include "support/test_meshes.h"

namespace plait::test {
namespace {

template <class Id>
std::vector<Id> listed(const std::set<Id>& ids) {
  return {ids.begin(), ids.end()};
}

}  // namespace

TEST_CASE("FaceRings_OfAnyRange_AreThoseOfACountOfAllFaces") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const BaseMesh made = BaseMesh::build(named.mesh);
    const Topology mesh = made.topology();
    FaceRings rings(mesh);
    const auto edges = static_cast<EdgeId>(mesh.edges.size());
    for (const EdgeId first : {EdgeId{0}, edges / 3, edges - 1}) {
      const EdgeId after = std::min(first + 1 + edges / 5, edges);
      rings.begin(first, after);
      std::set<FaceId> faces;
      for (FaceId face = 0; face < mesh.faces.size(); ++face)
        for (const EdgeId edge : mesh.face_edges[face])
          if (edge >= first && edge < after) faces.insert(face);
      for (std::size_t ring = 0; ring < 4; ++ring) {
        std::set<VertexId> vertices;
        std::set<EdgeId> at_faces;
        for (const FaceId face : faces) {
          vertices.insert(mesh.faces[face].begin(), mesh.faces[face].end());
          at_faces.insert(mesh.face_edges[face].begin(), mesh.face_edges[face].end());
        }
        std::vector<FaceId> found(rings.faces(ring).begin(), rings.faces(ring).end());
        std::ranges::sort(found);
        CHECK(found == listed(faces));
        CHECK(rings.vertices(ring) == listed(vertices));
        CHECK(rings.edges(ring) == listed(at_faces));
        const std::size_t before = faces.size();
        for (FaceId face = 0; face < mesh.faces.size(); ++face)
          for (const VertexId vertex : mesh.faces[face])
            if (vertices.contains(vertex)) faces.insert(face);
        CHECK(rings.grow() == (faces.size() > before));
      }
      CHECK(rings.rings() == 4);
      CHECK(rings.faces(9).size() == rings.faces(4).size());
    }
  }
}

}  // namespace plait::test
