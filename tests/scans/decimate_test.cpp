#include "collapse/decimate.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "collapse/collapsing_mesh.h"
#include "plait/error.h"
#include "support/error_of.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

Surface surface_of(const IndexedMesh& mesh) { return repair(mesh, {}, "mesh").surface; }

/// What must not change. A vertex count follows.
std::array<std::int64_t, 3> topology_of(const SurfaceFigures& figures) {
  return {figures.euler_number, static_cast<std::int64_t>(figures.components),
          static_cast<std::int64_t>(figures.borders)};
}

/// Builds the connectivity anew, which also proves that the faces are an oriented manifold.
SurfaceFigures figures_of_faces(const std::vector<Point>& positions,
                                const std::vector<std::array<VertexId, 3>>& faces) {
  const Repaired result = repair({positions, faces}, {}, "decimated");
  CHECK(result.list.is_clean());
  return figures_of(result.surface);
}

}  // namespace

TEST_CASE("CollapsingMesh_RandomCollapsesOfEveryMesh_KeepItsTopology") {
  std::mt19937 random(4);
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const Surface scan = surface_of(named.mesh);
    const auto before = topology_of(figures_of(scan));
    CollapsingMesh mesh(scan);
    Patch patch;
    std::size_t collapses = 0;
    for (int attempt = 0; attempt < 2000; ++attempt) {
      const auto face = static_cast<FaceId>(random() % scan.faces.size());
      const FaceSide edge(face, static_cast<int>(random() % 3));
      if (!mesh.lives(face) || !mesh.gather(edge, patch)) continue;
      mesh.collapse(patch);
      ++collapses;
    }
    std::vector<std::array<VertexId, 3>> faces;
    for (FaceId face = 0; face < scan.faces.size(); ++face)
      if (mesh.lives(face)) faces.push_back(mesh.faces()[face]);
    CHECK(faces.size() == mesh.live_faces());
    std::vector<Point> positions = scan.positions;
    Repaired result = repair({positions, faces}, {}, "collapsed");
    result.list.unused_vertices = 0;  // those that collapsed
    CHECK(result.list.is_clean());
    CHECK(topology_of(figures_of(result.surface)) == before);
    if (scan.faces.size() > 200) CHECK(collapses > 20);
  }
}

TEST_CASE("Decimate_ClosedSurface_ReachesItsFacesAndKeepsItsTopology") {
  const Surface scan = surface_of(torus_grid(60, 40));
  const Decimated result = decimate(scan, {.faces = 200});
  CHECK(result.faces.size() <= 200);
  CHECK(result.faces.size() >= 199);
  CHECK(result.scan_faces.size() == result.faces.size());
  CHECK(topology_of(figures_of_faces(result.positions, result.faces)) ==
        topology_of(figures_of(scan)));
  CHECK(result.history.collapse_count() == scan.positions.size() - result.positions.size());
}

TEST_CASE("Decimate_Components_KeepTheirBordersAndNumbers") {
  const Surface scan = surface_of(side_by_side({sheet(30, 30), torus_grid(20, 20), sheet(12, 9)}));
  const Decimated result = decimate(scan, {.faces = 150});
  CHECK(result.faces.size() <= 150);
  CHECK(topology_of(figures_of_faces(result.positions, result.faces)) ==
        topology_of(figures_of(scan)));
}

TEST_CASE("Decimate_TooFewFaces_StopsAndSaysWhatKeptThem") {
  const Surface scan = surface_of(torus_grid(20, 20));
  const Decimated result = decimate(scan, {.faces = 4});  // a torus has 14 faces or more
  CHECK(result.faces.size() >= 14);
  CHECK(result.limits.by_topology + result.limits.by_shape > 0);
}

TEST_CASE("Decimate_SameScan_GivesSameBits") {
  const Surface scan = surface_of(random_sphere(7, 800));
  const Decimated first = decimate(scan, {.faces = 60}), second = decimate(scan, {.faces = 60});
  CHECK(first.faces == second.faces);
  CHECK(first.positions == second.positions);
}

TEST_CASE("Decimate_CancelledByItsCaller_IsAnError") {
  const Surface scan = surface_of(torus_grid(80, 80));
  int calls = 0;
  const DecimateOptions options{.faces = 20,
                                .progress = [&](const Progress&) { return ++calls < 2; }};
  CHECK(error_of([&] { decimate(scan, options); }).code() == ErrorCode::kCancelled);
}

TEST_CASE("Decimate_BorderOfFlatSquare_StaysOnTheSquare") {
  IndexedMesh flat = sheet(24, 24);
  for (Point& p : flat.positions) p.z = 0;
  const Decimated result = decimate(surface_of(flat), {.faces = 40});
  double area = 0;
  for (const auto& [a, b, c] : result.faces)
    area += area_vector(result.positions[a], result.positions[b], result.positions[c]).z / 2;
  double before = 0;
  for (const auto& [a, b, c] : flat.faces)
    before += area_vector(flat.positions[a], flat.positions[b], flat.positions[c]).z / 2;
  CHECK(area == Approx(before).epsilon(0.02));
}

}  // namespace plait::test
