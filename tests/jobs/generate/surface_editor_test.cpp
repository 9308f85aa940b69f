#include "generate/surface_editor.h"

#include <catch2/catch.hpp>
#include <vector>

#include "generate/reduce.h"
#include "support/test_meshes.h"

using namespace plait;
using generation::SurfaceEditor;

namespace {

long euler_number(const BaseMesh& mesh) {
  return static_cast<long>(mesh.vertex_count()) - static_cast<long>(mesh.edge_count()) +
         static_cast<long>(mesh.face_count());
}

int collapsible_sides(const IndexedMesh& mesh) {
  const SurfaceEditor editor(mesh);
  int count = 0;
  for (SurfaceEditor::Side side = 0; side < editor.side_limit(); ++side)
    count += editor.can_collapse(side) ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("CanCollapse_SurfacesThatAreAsSmallAsTheyGet_IsFalseEverywhere") {
  CHECK(collapsible_sides(test::tetrahedron()) == 0);
  CHECK(collapsible_sides(test::seven_vertex_torus()) == 0);
  CHECK(collapsible_sides(test::single_triangle()) == 0);
  CHECK(collapsible_sides(test::octahedron()) == 24);
}

TEST_CASE("CanCollapse_InnerEdgeBetweenBorderVertices_IsFalse") {
  // Only the edge that the two triangles share cannot be collapsed. The four border edges can.
  const SurfaceEditor editor(test::two_triangles());
  for (SurfaceEditor::Side side = 0; side < editor.side_limit(); ++side)
    CHECK(editor.can_collapse(side) == editor.is_border(side));
}

TEST_CASE("Collapse_EverySideOfEveryMesh_KeepsAManifoldOfTheSameEulerNumber") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    INFO(named.name);
    if (named.mesh.faces.size() > 300) continue;
    const BaseMesh before = BaseMesh::build(named.mesh);
    const SurfaceEditor editor(named.mesh);
    for (SurfaceEditor::Side side = 0; side < editor.side_limit(); ++side) {
      if (!editor.can_collapse(side)) continue;
      SurfaceEditor collapsed = editor;
      collapsed.collapse(side, {0, 0, 0});
      const BaseMesh after = BaseMesh::build(std::move(collapsed).take());
      CHECK(after.vertex_count() + 1 == before.vertex_count());
      CHECK(euler_number(after) == euler_number(before));
    }
  }
}

TEST_CASE("Valence_EveryMesh_EqualsTheEdgesOfTheVertex") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    INFO(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    const SurfaceEditor editor(named.mesh);
    std::vector<int> edges(mesh.vertex_count(), 0);
    std::vector<bool> border(mesh.vertex_count(), false);
    for (const Edge& edge : mesh.edges()) {
      for (const VertexId vertex : {edge.start, edge.end}) {
        ++edges[vertex];
        if (edge.is_border()) border[vertex] = true;
      }
    }
    for (VertexId vertex = 0; vertex < edges.size(); ++vertex) {
      CHECK(editor.valence(vertex) == edges[vertex]);
      CHECK(editor.is_on_border(vertex) == border[vertex]);
    }
  }
}

TEST_CASE("Reduce_ToLessThanThereCanBe_StopsAtASurfaceOfTheSameTopology") {
  const GeneratorProgress ignore = [](double) {};
  const generation::Progress silent(ignore);
  const BaseMesh sphere =
      BaseMesh::build(generation::reduce(test::random_sphere(5, 200), {1, 0, 0}, silent));
  CHECK(sphere.vertex_count() == 4);
  CHECK(euler_number(sphere) == 2);
  const BaseMesh torus =
      BaseMesh::build(generation::reduce(test::random_torus(5, 200), {1, 0, 0}, silent));
  CHECK(torus.vertex_count() >= 7);
  CHECK(euler_number(torus) == 0);
}
