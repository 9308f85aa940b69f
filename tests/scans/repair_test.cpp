#include "surface/repair.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "plait/error.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

Repaired repaired(IndexedMesh mesh, const SurfaceRepairOptions& options = {}) {
  Repaired result = repair(std::move(mesh), options, "mesh");
  // The independent check of the engine: an oriented 2-manifold without unused vertices.
  std::vector<std::string> changes;
  BaseMesh::build({result.surface.positions, result.surface.faces}, "repaired", &changes);
  CHECK(changes.empty());
  CHECK(result.origin.size() == result.surface.positions.size());
  CHECK(result.face_origin.size() == result.surface.faces.size());
  return result;
}

/// A strip of n squares whose end is turned over before it meets the start.
IndexedMesh moebius_strip(std::uint32_t n) {
  IndexedMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double x = i;
    mesh.positions.push_back({x, 0, 0});
    mesh.positions.push_back({x, 1, 0});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const std::uint32_t a = 2 * i, b = 2 * i + 1, c = last ? 1 : a + 2, d = last ? 0 : b + 2;
    mesh.faces.push_back({a, c, b});
    mesh.faces.push_back({b, c, d});
  }
  return mesh;
}

}  // namespace

TEST_CASE("Repair_EveryCleanMesh_StaysAsItIs") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const Repaired result = repaired(named.mesh);
    CHECK(result.list.is_clean());
    CHECK(result.surface.faces == named.mesh.faces);
    const BaseMesh base = BaseMesh::build(named.mesh);
    const SurfaceFigures figures = figures_of(result.surface);
    CHECK(figures.edges == base.edge_count());
    CHECK(figures.border_edges == base.border_edge_count());
  }
}

TEST_CASE("Figures_EdgesOfMoreThan150Degrees_AreFolded") {
  const auto folded = [](const IndexedMesh& mesh) {
    return figures_of(repaired(mesh).surface).folded_edges;
  };
  CHECK(folded(octahedron()) == 0);
  // Two faces of a hinge: so many degrees are between their normals.
  const auto hinge = [](double degrees) {
    const double angle = degrees * 3.14159265358979323846 / 180;
    return IndexedMesh{
        {{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-std::cos(angle), 0.5, std::sin(angle)}},
        {{1, 0, 2}, {0, 1, 3}}};
  };
  CHECK(folded(hinge(149)) == 0);
  CHECK(folded(hinge(151)) == 1);
  IndexedMesh needle = hinge(176);
  needle.positions[3] = {0, 0.5, 0};  // a face without area has no normal
  CHECK(folded(needle) == 0);
}

TEST_CASE("Figures_KnownMeshes_HaveTheirTopology") {
  const auto figures = [](const IndexedMesh& mesh) { return figures_of(repaired(mesh).surface); };
  CHECK(figures(octahedron()).euler_number == 2);
  CHECK(figures(torus_grid(5, 4)).euler_number == 0);
  const SurfaceFigures ring = figures(annulus(6));
  CHECK(ring.borders == 2);
  CHECK(ring.euler_number == 0);
  const SurfaceFigures two = figures(two_components());
  CHECK(two.components == 2);
  CHECK(two.borders == 1);
  CHECK(two.euler_number == 3);
}

TEST_CASE("Repair_BadFacesAndVertices_AreRemovedAndCounted") {
  IndexedMesh mesh = octahedron();
  const auto faces = mesh.faces;
  const auto far = static_cast<VertexId>(mesh.positions.size());
  mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  mesh.positions.push_back({7, 7, 7});
  mesh.faces.push_back({0, 1, far});
  mesh.faces.push_back({0, 1, 1});
  mesh.faces.push_back({faces[2][1], faces[2][2], faces[2][0]});
  mesh.faces.push_back({faces[3][2], faces[3][1], faces[3][0]});
  const Repaired result = repaired(mesh);
  CHECK(result.surface.faces == faces);
  CHECK(result.face_origin.back() == faces.size() - 1);
  CHECK(result.list.not_finite_vertices == 1);
  CHECK(result.list.not_finite_faces == 1);
  CHECK(result.list.degenerate_faces == 1);
  CHECK(result.list.duplicate_faces == 2);
  CHECK(result.list.unused_vertices == 2);
  CHECK_FALSE(result.list.is_clean());
}

TEST_CASE("Repair_EveryCoordinateThatIsNoNumber_IsFound") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity})
    for (int axis = 0; axis < 3; ++axis) {
      CAPTURE(value, axis);
      IndexedMesh mesh = torus_grid(6, 5);
      mesh.positions[8][axis] = value;
      const Repaired result = repaired(mesh);
      CHECK(result.list.not_finite_vertices == 1);
      CHECK(result.list.not_finite_faces == 6);
      CHECK(result.surface.faces.size() == mesh.faces.size() - 6);
    }
}

TEST_CASE("Repair_TurnedFaces_FollowMostOfTheirComponent") {
  IndexedMesh mesh = side_by_side({torus_grid(6, 5), sheet(4, 4)});
  const IndexedMesh before = mesh;
  for (const std::size_t face : {std::size_t{3}, std::size_t{17}, mesh.faces.size() - 1})
    std::swap(mesh.faces[face][1], mesh.faces[face][2]);
  const Repaired result = repaired(mesh);
  CHECK(result.list.turned_faces == 3);
  CHECK(figures_of(result.surface).euler_number ==
        figures_of(repaired(before).surface).euler_number);
  CHECK(result.surface.faces == before.faces);
}

TEST_CASE("Repair_EdgeOfThreeFaces_IsCutApart") {
  // Three fins at the edge 0-1.
  const IndexedMesh mesh{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}},
                         {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}};
  const Repaired result = repaired(mesh);
  CHECK(result.list.non_manifold_edges == 1);
  CHECK(result.list.non_manifold_vertices == 2);
  const SurfaceFigures figures = figures_of(result.surface);
  CHECK(figures.components == 3);
  CHECK(figures.vertices == 9);
}

TEST_CASE("Repair_BowTie_GetsTwoVertices") {
  const IndexedMesh mesh{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
                         {{0, 1, 2}, {0, 3, 4}}};
  const Repaired result = repaired(mesh);
  CHECK(result.list.non_manifold_vertices == 1);
  CHECK(result.surface.positions.size() == 6);
  CHECK(result.origin.back() == 0);
}

TEST_CASE("Repair_TwoSpheresAtOneEdge_BecomeTwoClosedSpheres") {
  IndexedMesh mesh = side_by_side({octahedron(), octahedron()});
  const auto [a, b, c] = mesh.faces[0];
  const auto [d, e, f] = mesh.faces[8];
  for (auto& face : mesh.faces)
    for (VertexId& vertex : face) {
      if (vertex == d) vertex = a;
      if (vertex == e) vertex = b;
    }
  const Repaired result = repaired(mesh);
  CHECK(result.list.non_manifold_edges == 1);
  const SurfaceFigures figures = figures_of(result.surface);
  CHECK(figures.components == 2);
  CHECK(figures.border_edges == 0);
  CHECK(figures.euler_number == 4);
}

TEST_CASE("Repair_MoebiusStrip_IsRefusedWithItsPlace") {
  const Error error = error_of([] { repair(moebius_strip(6), {}, "strip.ply"); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK_THAT(error.what(), Catch::Matchers::StartsWith("strip.ply: the edge of the vertices "));
}

TEST_CASE("Repair_NoFaceThatCanStay_IsRefused") {
  const IndexedMesh mesh{{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 1}}};
  CHECK(error_of([&] { repair(mesh, {}, "mesh"); }).code() == ErrorCode::kInvalidArgument);
  const IndexedMesh wild{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}};
  CHECK(error_of([&] { repair(wild, {}, "mesh"); }).code() == ErrorCode::kInvalidArgument);
}

TEST_CASE("Repair_SmallComponents_AreRemovedOnRequest") {
  const IndexedMesh mesh = side_by_side({tetrahedron(), octahedron(), tetrahedron()});
  const Repaired result = repaired(mesh, {.min_component = 8});
  CHECK(result.list.small_components == 2);
  CHECK(result.list.small_component_faces == 8);
  CHECK(figures_of(result.surface).components == 1);
  CHECK(result.surface.faces.size() == 8);
  CHECK(result.face_origin.front() == 4);
}

TEST_CASE("Repair_Holes_AreFilledUpToTheirSize") {
  IndexedMesh mesh = torus_grid(8, 8);
  mesh.faces.erase(mesh.faces.begin() + 40);
  mesh.faces.erase(mesh.faces.begin(), mesh.faces.begin() + 2);  // a hole of four edges
  CHECK(figures_of(repaired(mesh).surface).borders == 2);
  const Repaired one = repaired(mesh, {.fill_holes = 3});
  CHECK(one.list.filled_holes == 1);
  CHECK(figures_of(one.surface).borders == 1);
  const Repaired both = repaired(mesh, {.fill_holes = 4});
  CHECK(both.list.filled_holes == 2);
  CHECK(both.list.filled_hole_faces == 7);
  CHECK(figures_of(both.surface).euler_number == 0);
  CHECK(both.origin.back() == kNoId);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    REQUIRE(both.face_origin[face] == face);
  for (std::size_t face = mesh.faces.size(); face < both.face_origin.size(); ++face)
    REQUIRE(both.face_origin[face] == kNoId);
}

// A fan would have all edges of the hole at one vertex.
TEST_CASE("Repair_LargeHole_IsFilledWithoutVerticesOfManyFaces") {
  for (const double radius : {2.3, 4.1, 9.0, 17.5}) {
    CAPTURE(radius);
    IndexedMesh mesh = sheet(40, 40);
    for (Point& p : mesh.positions) p.z = 0;
    std::erase_if(mesh.faces, [&](const auto& face) {
      return length(mesh.positions[face[0]] - Point{20, 20, 0}) < radius;
    });
    const SurfaceFigures before = figures_of(repaired(mesh).surface);
    REQUIRE(before.borders == 2);
    const Repaired filled = repaired(mesh, {.fill_holes = before.border_edges - 160});
    CHECK(filled.list.filled_holes == 1);
    const SurfaceFigures figures = figures_of(filled.surface);
    CHECK(figures.borders == 1);
    CHECK(figures.euler_number == 1);
    // The sides know each other as they do when the faces are read again.
    CHECK(filled.surface.across ==
          repaired({filled.surface.positions, filled.surface.faces}).surface.across);
    std::vector<int> faces_at(filled.surface.positions.size(), 0);
    double area = 0;
    for (const auto& face : filled.surface.faces) {
      for (const VertexId vertex : face) ++faces_at[vertex];
      const Point normal =
          area_vector(filled.surface.positions[face[0]], filled.surface.positions[face[1]],
                      filled.surface.positions[face[2]]);
      CHECK(normal.z > 0);
      area += normal.z / 2;
    }
    CHECK(area == Approx(40 * 40));
    CHECK(*std::ranges::max_element(faces_at) <= 12);
  }
}

}  // namespace plait::test
