#include "distance/crossings.h"

#include <tbb/task_arena.h>

#include <catch2/catch.hpp>

#include "support/test_meshes.h"

namespace plait::test {
namespace {

Crossings crossings_of(const IndexedMesh& mesh) {
  return find_crossings({mesh.positions, mesh.faces}, TriangleTree(mesh.positions, mesh.faces));
}

/// Both meshes at their places, as one.
IndexedMesh together(IndexedMesh mesh, const IndexedMesh& other) {
  const auto before = static_cast<VertexId>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const auto& [a, b, c] : other.faces)
    mesh.faces.push_back({a + before, b + before, c + before});
  return mesh;
}

IndexedMesh flat_squares(std::uint32_t columns, std::uint32_t rows, double height) {
  IndexedMesh mesh = sheet(columns, rows);
  for (Point& p : mesh.positions) p.z = height;
  return mesh;
}

}  // namespace

TEST_CASE("FindCrossings_SurfacesThatTouchOrLieBesideEachOther_HaveNone") {
  CHECK(crossings_of(cube_grid(6)).faces == 0);
  CHECK(crossings_of(torus_grid(30, 20)).faces == 0);
  // A seam: each vertex is there twice.
  CHECK(crossings_of(together(flat_squares(5, 4, 0), flat_squares(5, 4, 0))).faces == 0);
  CHECK(crossings_of(together(flat_squares(5, 4, 0), flat_squares(5, 4, 1e-5))).faces == 0);
  // A ridge that stands on the sheet.
  const IndexedMesh ridge = {{{0.3, 0.4, 0}, {4.2, 0.4, 0}, {2, 0.4, 3}}, {{0, 1, 2}}};
  CHECK(crossings_of(together(flat_squares(5, 4, 0), ridge)).faces == 0);
}

TEST_CASE("FindCrossings_TriangleThroughASheet_CountsAllFacesThatItMeets", "[threads]") {
  // Of the squares 1 to 3 of a row, it meets both triangles.
  const IndexedMesh blade = {{{1.1, 0.55, -1}, {3.9, 0.55, -1}, {2.5, 0.55, 100}}, {{0, 1, 2}}};
  for (const double far : {0.0, 6e6}) {
    CAPTURE(far);
    IndexedMesh mesh = together(flat_squares(5, 4, 0), blade);
    for (Point& p : mesh.positions) p = p + Point{far, -far, 0};
    for (const int threads : {1, 4}) {
      Crossings found;
      tbb::task_arena(threads).execute([&] { found = crossings_of(mesh); });
      CHECK(found.faces == 7);
      CHECK(length(found.first - Point{far + 2, -far + 0.5, 0}) < 2);
    }
  }
}

TEST_CASE("FindCrossings_TetrahedronInsideAnother_CrossesItWhereItReachesOut") {
  const IndexedMesh outside = tetrahedron();
  for (const double shift : {0.0, 0.9}) {
    IndexedMesh inside = outside;
    for (Point& p : inside.positions) p = 0.2 * p + Point{shift, 0, 0};
    CAPTURE(shift);
    CHECK((crossings_of(together(outside, inside)).faces > 0) == (shift > 0));
  }
}

TEST_CASE("FindCrossings_NeedlesAcrossEachOther_EndsAndSaysWhere", "[threads]") {
  // All boxes are nearly the whole cube, and no needle meets another one.
  IndexedMesh mesh;
  constexpr std::uint32_t kNeedles = 1600;
  for (std::uint32_t i = 0; i < kNeedles; ++i) {
    const double at = i * 1e-7;
    mesh.positions.insert(mesh.positions.end(),
                          {{at, 0, 0}, {1 + at, 1, 1}, {1 + at, 1, 1 + 1e-3}});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const TriangleTree tree(mesh.positions, mesh.faces);
  const TriangleSet triangles{mesh.positions, mesh.faces};
  CHECK(find_crossings(triangles, tree).examined == kNeedles);
  for (const int threads : {1, 4}) {
    Crossings found;
    tbb::task_arena(threads).execute([&] { found = find_crossings(triangles, tree, {}, 0); });
    // 256 comparisons for each face are those of 256 faces.
    CHECK(found.examined == 256);
    CHECK(found.faces == 0);
  }
}

}  // namespace plait::test
