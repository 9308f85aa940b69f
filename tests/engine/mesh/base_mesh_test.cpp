#include "plait/base_mesh.h"

#include <catch2/catch.hpp>
#include <limits>
#include <numeric>

#include "plait/error.h"
#include "shapes.h"

using namespace plait;
using Catch::Contains;
using shapes::check_topology;
using shapes::refusal;
using shapes::with_any_positions;

namespace {

std::string refusal_of(IndexedMesh mesh) {
  return refusal([&] { BaseMesh::build(std::move(mesh), "shape.ply"); });
}

void check_counts(const BaseMesh& mesh, std::uint64_t vertices, std::uint64_t edges,
                  std::uint64_t faces, std::uint64_t border_edges) {
  CHECK(mesh.vertex_count() == vertices);
  CHECK(mesh.edge_count() == edges);
  CHECK(mesh.face_count() == faces);
  CHECK(mesh.border_edge_count() == border_edges);
  check_topology(mesh);
}

}  // namespace

TEST_CASE("BaseMeshBuild_KnownShapes_HaveTheirCounts") {
  check_counts(BaseMesh::build(shapes::tetrahedron()), 4, 6, 4, 0);
  check_counts(BaseMesh::build(shapes::octahedron()), 6, 12, 8, 0);
  check_counts(BaseMesh::build(shapes::torus(5, 7)), 35, 105, 70, 0);
  check_counts(BaseMesh::build(shapes::open_fan(1)), 3, 3, 1, 3);
  check_counts(BaseMesh::build(shapes::open_fan(6)), 8, 13, 6, 8);
  check_counts(BaseMesh::build(shapes::double_cone(3)), 5, 9, 6, 0);
  CHECK(shapes::euler_number(BaseMesh::build(shapes::octahedron())) == 2);
  CHECK(shapes::euler_number(BaseMesh::build(shapes::torus(5, 7))) == 0);
}

TEST_CASE("BaseMeshBuild_TwoFacesBackToBack_AreAClosedSurface") {
  check_counts(BaseMesh::build(with_any_positions(3, {{0, 1, 2}, {0, 2, 1}})), 3, 3, 2, 0);
}

TEST_CASE("BaseMeshBuild_Tetrahedron_NumbersEdgesByFirstUse") {
  const BaseMesh mesh = BaseMesh::build(shapes::tetrahedron());
  const std::vector<std::pair<VertexId, VertexId>> expected = {{0, 1}, {1, 2}, {0, 2},
                                                               {2, 3}, {0, 3}, {1, 3}};
  for (EdgeId edge = 0; edge < 6; ++edge) {
    CHECK(mesh.edges()[edge].start == expected[edge].first);
    CHECK(mesh.edges()[edge].end == expected[edge].second);
  }
  CHECK(mesh.face_edges()[0] == std::array<EdgeId, 3>{1, 2, 0});
  // Edge 0-2 runs 2 -> 0 in face 0, so face 1 owns it.
  CHECK(mesh.edges()[2].own == FaceSide(1, 2));
  CHECK(mesh.edges()[2].other == FaceSide(0, 1));
}

TEST_CASE("BaseMeshBuild_BorderEdge_RunsAsItsOnlyFaceDoes") {
  const BaseMesh mesh = BaseMesh::build(with_any_positions(3, {{2, 1, 0}}));
  CHECK(mesh.edges()[0].start == 2);
  CHECK(mesh.edges()[0].end == 1);
  CHECK(mesh.edges()[2].start == 0);
  CHECK(mesh.edges()[2].end == 2);
}

TEST_CASE("BaseMeshBuild_ValenceOneHundredThousand_IsLinear") {
  constexpr VertexId kValence = 100'000;
  SECTION("double cone") {
    check_counts(BaseMesh::build(shapes::double_cone(kValence)), kValence + 2, 3 * kValence,
                 2 * kValence, 0);
  }
  SECTION("open fan") {
    check_counts(BaseMesh::build(shapes::open_fan(kValence)), kValence + 2, 2 * kValence + 1,
                 kValence, kValence + 2);
  }
  SECTION("apex with the highest index") {
    IndexedMesh mesh = shapes::double_cone(kValence);
    for (auto& face : mesh.faces)
      for (VertexId& vertex : face) vertex = kValence + 1 - vertex;
    check_counts(BaseMesh::build(std::move(mesh)), kValence + 2, 3 * kValence, 2 * kValence, 0);
  }
}

TEST_CASE("BaseMeshBuild_FlippedFaces_AreTurnedBackWithAWarning") {
  const IndexedMesh straight = shapes::torus(6, 8);
  IndexedMesh mixed = straight;
  for (const std::size_t face : {1u, 2u, 30u, 31u, 95u})
    std::swap(mixed.faces[face][1], mixed.faces[face][2]);
  std::vector<std::string> warnings;
  const BaseMesh mesh = BaseMesh::build(mixed, "torus", &warnings);
  check_topology(mesh);
  CHECK(std::equal(mesh.faces().begin(), mesh.faces().end(), straight.faces.begin()));
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0] ==
        "torus: 5 of 96 faces flipped to the orientation of the first face of their component");
}

TEST_CASE("BaseMeshBuild_FirstFaceOfEachComponent_GivesItsOrientation") {
  IndexedMesh mesh = shapes::tetrahedron();
  for (std::size_t face = 0; face < 4; ++face) {
    auto copy = mesh.faces[face];
    for (VertexId& vertex : copy) vertex += 4;
    if (face == 0) std::swap(copy[1], copy[2]);
    mesh.faces.push_back(copy);
  }
  mesh.positions = with_any_positions(8, {}).positions;
  const BaseMesh built = BaseMesh::build(mesh);
  check_topology(built);
  CHECK(built.faces()[0] == mesh.faces[0]);
  CHECK(built.faces()[4] == mesh.faces[4]);
  CHECK(built.faces()[5] == std::array<VertexId, 3>{4, 7, 6});
}

TEST_CASE("BaseMeshBuild_UnusedVertices_AreDroppedWithAWarning") {
  IndexedMesh mesh = with_any_positions(7, {{1, 3, 6}, {1, 6, 4}});
  std::vector<std::string> warnings;
  const BaseMesh built = BaseMesh::build(mesh, "sparse", &warnings);
  check_counts(built, 4, 5, 2, 4);
  CHECK(built.faces()[1] == std::array<VertexId, 3>{0, 3, 2});
  CHECK(built.positions()[2] == mesh.positions[4]);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0] == "sparse: 3 of 7 vertices dropped: no face uses them");
  CHECK_NOTHROW(BaseMesh::build(mesh));
}

TEST_CASE("BaseMeshBuild_BadElement_IsRefusedByName") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  IndexedMesh mesh = shapes::tetrahedron();
  SECTION("no faces") {
    CHECK(refusal_of({}) == "shape.ply: expected at least one face, found none");
  }
  SECTION("nan") {
    mesh.positions[2].y = nan;
    CHECK_THAT(refusal_of(mesh), Contains("shape.ply: vertex 2: expected a finite position"));
  }
  SECTION("infinity") {
    mesh.positions[3].z = -infinity;
    CHECK_THAT(refusal_of(mesh), Contains("vertex 3") && Contains("-inf"));
  }
  SECTION("index out of range") {
    mesh.faces[1][2] = 4;
    CHECK(refusal_of(mesh) == "shape.ply: face 1: expected vertices below 4, found 4");
  }
  SECTION("vertex twice") {
    mesh.faces[3] = {1, 3, 1};
    CHECK(refusal_of(mesh) ==
          "shape.ply: face 3: expected three different vertices, found 1 3 1; plait check counts "
          "such places, and plait remesh repairs them");
  }
  SECTION("face twice") {
    CHECK_THAT(refusal_of(with_any_positions(3, {{0, 1, 2}, {1, 2, 0}})),
               Contains("face 1: expected a new face, found a copy of face 0"));
  }
}

TEST_CASE("BaseMeshBuild_NonManifoldEdge_IsRefusedWithItsFaces") {
  CHECK(refusal_of(with_any_positions(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})) ==
        "shape.ply: edge 0-1: expected at most two faces, found 3: faces 0, 1, 2; plait check "
        "counts such places, and plait remesh repairs them");
  // A thousand faces at one edge: the message must stay short.
  shapes::Faces sheets;
  for (VertexId v = 2; v < 1002; ++v) sheets.push_back({0, 1, v});
  CHECK_THAT(refusal_of(with_any_positions(1002, sheets)),
             Contains("found 1000: faces 0, 1, 2, ..."));
}

TEST_CASE("BaseMeshBuild_NonManifoldVertex_IsRefused") {
  SECTION("two borders meet") {
    CHECK(refusal_of(with_any_positions(5, {{2, 0, 1}, {2, 3, 4}})) ==
          "shape.ply: vertex 2: expected its 2 faces to form one fan, found only 1 in the fan of "
          "face 0; plait check counts such places, and plait remesh repairs them");
  }
  SECTION("two closed surfaces touch") {
    IndexedMesh mesh = shapes::tetrahedron();
    for (std::size_t face = 0; face < 4; ++face) {
      auto copy = mesh.faces[face];
      for (VertexId& vertex : copy) vertex = vertex == 3 ? 3 : vertex + 4;
      mesh.faces.push_back(copy);
    }
    mesh.positions = with_any_positions(7, {}).positions;
    CHECK_THAT(refusal_of(mesh), Contains("vertex 3: expected its 6 faces to form one fan"));
  }
  SECTION("messages name vertices as the input does") {
    CHECK_THAT(refusal_of(with_any_positions(9, {{6, 4, 5}, {6, 7, 8}})), Contains("vertex 6"));
  }
}

TEST_CASE("BaseMeshBuild_OneSidedSurface_IsRefusedWithAnEdgeAndTwoFaces") {
  for (const VertexId faces : {5u, 7u, 101u})
    CHECK_THAT(refusal_of(shapes::moebius_strip(faces)),
               Contains("edge ") && Contains("expected faces ") && Contains("only one side"));
}

TEST_CASE("WithFaceOrder_AnyPermutation_KeepsEdgeFrames") {
  for (const IndexedMesh& input : {shapes::torus(7, 9), shapes::open_fan(40)}) {
    const BaseMesh mesh = BaseMesh::build(input);
    std::vector<FaceId> order(mesh.face_count());
    // 37 divides neither 126 nor 40: a permutation.
    for (std::size_t face = 0; face < order.size(); ++face)
      order[face] = static_cast<FaceId>(37 * face % order.size());
    const BaseMesh moved = mesh.with_face_order(order);
    check_topology(moved);
    REQUIRE(moved.edge_count() == mesh.edge_count());
    CHECK(std::equal(mesh.positions().begin(), mesh.positions().end(), moved.positions().begin()));
    for (FaceId face = 0; face < order.size(); ++face) {
      REQUIRE(moved.faces()[face] == mesh.faces()[order[face]]);
      for (std::size_t side = 0; side < 3; ++side) {
        const Edge& before = mesh.edges()[mesh.face_edges()[order[face]][side]];
        const Edge& after = moved.edges()[moved.face_edges()[face][side]];
        REQUIRE(before.start == after.start);
        REQUIRE(before.end == after.end);
        REQUIRE(order[after.own.face()] == before.own.face());
        REQUIRE(after.own.side() == before.own.side());
      }
    }
    const auto corners = moved.topology().vertex_corners;
    for (VertexId v = 0; v < corners.size(); ++v)
      REQUIRE(FaceSide(order[corners[v].face()], corners[v].side()) ==
              mesh.topology().vertex_corners[v]);
  }
}

TEST_CASE("WithFaceOrder_NoPermutation_IsRefused") {
  const BaseMesh mesh = BaseMesh::build(shapes::tetrahedron());
  const auto refused = [&](std::vector<FaceId> order) {
    return refusal([&] { mesh.with_face_order(order); });
  };
  CHECK_THAT(refused({0, 1, 2}), Contains("expected 4 faces, found 3"));
  CHECK_THAT(refused({0, 1, 1, 2}), Contains("entry 2"));
  CHECK_THAT(refused({0, 1, 2, 4}), Contains("entry 3"));
}

TEST_CASE("CountsAtLevel_AnyMesh_FollowTheClosedForms") {
  for (const IndexedMesh& input :
       {shapes::tetrahedron(), shapes::torus(4, 5), shapes::open_fan(5)}) {
    const BaseMesh mesh = BaseMesh::build(input);
    const std::int64_t euler = shapes::euler_number(mesh);
    for (int level = 0; level <= 20; ++level) {
      const LevelCounts counts = counts_at_level(mesh, level);
      const std::uint64_t quadruple = std::uint64_t{1} << (2 * level);
      const std::uint64_t border = mesh.border_edge_count() << level;
      REQUIRE(counts.faces == mesh.face_count() * quadruple);
      REQUIRE(2 * counts.edges == 3 * counts.faces + border);
      REQUIRE(static_cast<std::int64_t>(counts.vertices + counts.faces - counts.edges) == euler);
    }
  }
}

TEST_CASE("CountsAtLevel_OutOfRange_IsRefused") {
  const BaseMesh mesh = BaseMesh::build(shapes::tetrahedron());
  CHECK_THAT(refusal([&] { counts_at_level(mesh, -1); }), Contains("found -1"));
  CHECK_THAT(refusal([&] { counts_at_level(mesh, 21); }), Contains("found 21"));
}

TEST_CASE("MemoryBytes_ClosedMesh_IsLittleMoreThanItsArrays") {
  const BaseMesh mesh = BaseMesh::build(shapes::torus(50, 50));
  const std::uint64_t arrays = 24 * mesh.vertex_count() + 24 * mesh.face_count() +
                               16 * mesh.edge_count() + 4 * mesh.vertex_count();
  CHECK(mesh.memory_bytes() >= arrays);
  CHECK(mesh.memory_bytes() <= arrays + arrays / 2);
}
