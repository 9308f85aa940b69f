#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "generate/marching_tetrahedra.h"
#include "generate/portable_math.h"
#include "generate/random.h"
#include "generate/reduce.h"
#include "generate/surface_editor.h"
#include "plait/progress.h"
#include "support/test_meshes.h"

namespace plait::test {
using namespace plait::generation;

TEST_CASE("PortableExp_WholeRange_IsWithinAFewRoundings") {
  for (double x = -690; x <= 690; x += 0.37)
    CHECK(portable_exp(x) == Approx(std::exp(x)).epsilon(1e-13));
  CHECK(portable_exp(0) == 1);
  CHECK(portable_exp(-1e6) == 0);
}

TEST_CASE("PortableSineCosine_SeveralTurns_IsWithinRounding") {
  for (double turns = -5; turns <= 5; turns += 0.0137) {
    const auto [sine, cosine] = portable_sine_cosine(turns);
    CHECK(sine == Approx(std::sin(2 * kPi * turns)).margin(2e-14));
    CHECK(cosine == Approx(std::cos(2 * kPi * turns)).margin(2e-14));
  }
}

using namespace plait::generation;

namespace {

const GeneratorProgress kSilent = [](double) {};

double volume(const IndexedMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces)
    sum += dot(mesh.positions[a], cross(mesh.positions[b], mesh.positions[c])) / 6;
  return sum;
}

}  // namespace

TEST_CASE("MarchTetrahedra_Ball_IsASphereOrientedOutwards") {
  constexpr std::size_t kPoints = 41;
  const Grid grid{{-1, -1, -1}, 2.0 / (kPoints - 1), kPoints, kPoints, kPoints};
  constexpr double kRadius = 0.8;
  const IndexedMesh ball = march_tetrahedra(
      grid, 0,
      [&](std::size_t z, std::span<float> values) {
        for (std::size_t y = 0; y < kPoints; ++y) {
          for (std::size_t x = 0; x < kPoints; ++x) {
            const Vector3<double> p =
                grid.origin + grid.spacing * Vector3<double>{static_cast<double>(x),
                                                             static_cast<double>(y),
                                                             static_cast<double>(z)};
            values[y * kPoints + x] = static_cast<float>(kRadius - std::sqrt(dot(p, p)));
          }
        }
      },
      generation::Progress(kSilent));
  const BaseMesh mesh = BaseMesh::build(ball);
  CHECK(mesh.border_edge_count() == 0);
  CHECK(mesh.vertex_count() + mesh.face_count() == mesh.edge_count() + 2);
  CHECK(volume(ball) == Approx(4.0 / 3 * 3.14159265 * kRadius * kRadius * kRadius).epsilon(0.01));
}

TEST_CASE("MarchTetrahedra_Noise_IsAClosedManifoldWhateverTheSigns") {
  // Every combination of signs around a cube occurs many times.
  constexpr std::size_t kPoints = 14;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const IndexedMesh noise = march_tetrahedra(
        {{0, 0, 0}, 1, kPoints, kPoints, kPoints}, 0.5f,
        [&](std::size_t z, std::span<float> values) {
          for (std::size_t y = 0; y < kPoints; ++y) {
            for (std::size_t x = 0; x < kPoints; ++x) {
              const bool outermost = x == 0 || y == 0 || z == 0 || x == kPoints - 1 ||
                                     y == kPoints - 1 || z == kPoints - 1;
              values[y * kPoints + x] = outermost ? 0 : static_cast<float>(random.unit());
            }
          }
        },
        generation::Progress(kSilent));
    std::vector<std::string> warnings;
    const BaseMesh mesh = BaseMesh::build(noise, "noise", &warnings);
    CHECK(mesh.vertex_count() > 1000);
    CHECK(mesh.border_edge_count() == 0);
    CHECK(warnings.empty());
    CHECK(volume(noise) > 0);
  }
}

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

}  // namespace plait::test
