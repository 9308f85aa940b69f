#include "surface/creases.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "collapse/decimate.h"
#include "sample/samples.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

Surface repaired_surface(const IndexedMesh& mesh) { return repair(mesh, {}, "mesh").surface; }

/// Walls and a bottom without a top: a border, and creases that end at it.
IndexedMesh open_box(std::uint32_t n) {
  IndexedMesh mesh = cube_grid(n);
  std::erase_if(mesh.faces, [&](const std::array<VertexId, 3>& face) {
    return std::ranges::all_of(face, [&](VertexId v) { return mesh.positions[v].z == n; });
  });
  return mesh;
}

/// How many of the three coordinates are at a side of the cube.
int sides_at(Point p, double n) {
  const auto is_at_side = [&](double x) { return std::min(std::abs(x), std::abs(x - n)) < 1e-12; };
  return static_cast<int>(is_at_side(p.x)) + static_cast<int>(is_at_side(p.y)) +
         static_cast<int>(is_at_side(p.z));
}

}  // namespace

TEST_CASE("FindCreases_OfACube_AreItsEdgesAndCorners") {
  const Surface cube = repaired_surface(cube_grid(6));
  const Creases creases = find_creases(cube, {});
  CHECK(creases.edge_count == 12 * 6);
  CHECK(creases.corner_count == 8);
  for (VertexId vertex = 0; vertex < cube.positions.size(); ++vertex)
    CHECK((creases.corners[vertex] != 0) == (sides_at(cube.positions[vertex], 6) == 3));
  CHECK(find_creases(cube, 89).edge_count == 12 * 6);
  CHECK(find_creases(cube, 91).edge_count == 0);
  CHECK(find_creases(cube, 180).edge_count == 0);

  // Each side of the cube is a part of its own.
  const Surface cut = cut_at(cube, creases);
  CHECK(cut.positions.size() == 6 * 7 * 7);
  CHECK(std::ranges::count_if(cut.across, [](FaceSide side) { return !side.exists(); }) == 144);
  for (FaceId face = 0; face < cube.faces.size(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      CHECK(length(cut.corner(face, corner) - cube.corner(face, corner)) == 0);

  // Where creases meet a border, they end.
  CHECK(find_creases(repaired_surface(open_box(6)), {}).corner_count == 8);
}

TEST_CASE("FindCreases_OfRoundedAndNoisySurfaces_AreNone") {
  CHECK(find_creases(repaired_surface(torus_grid(60, 30)), {}).edge_count == 0);
  for (const double noise : {0.1, 0.3, 1.0}) {
    IndexedMesh mesh = torus_grid(60, 30);
    std::mt19937 random(3);
    const double edge = length(mesh.positions[1] - mesh.positions[0]);
    std::uniform_real_distribution<double> shift(-noise * edge, noise * edge);
    for (Point& p : mesh.positions) p = p + Point{shift(random), shift(random), shift(random)};
    CHECK(find_creases(repaired_surface(mesh), {}).edge_count == 0);
    CHECK(find_creases(repaired_surface(mesh), 1).edge_count > 0);
  }
}

TEST_CASE("Decimate_Creases_AreMadeOfBaseEdgesWhosePointsStayOnThem") {
  constexpr std::uint32_t kSide = 12;
  for (const bool open : {false, true}) {
    const Surface scan = repaired_surface(open ? open_box(kSide) : cube_grid(kSide));
    const Creases creases = find_creases(scan, {});
    for (const std::uint64_t faces : {192u, 48u, open ? 10u : 12u}) {
      CAPTURE(open, faces);
      const Decimated result = decimate(scan, {.faces = faces, .creases = &creases});
      CHECK(result.faces.size() <= faces);
      CHECK(result.faces.size() + 1 >= faces);
      const BaseMesh base = BaseMesh::build({result.positions, result.faces}, "base");
      const SampleNumbers numbers(base, 3);
      const std::vector<SurfacePoint> samples =
          sample_scan(result.history, base, result.scan_faces, 3);
      const std::vector<std::uint8_t> on_creases = vertices_on_sides(base, 3, result.crease_sides);
      std::size_t corners = 0;
      double area = 0, volume = 0;
      for (std::uint64_t sample = 0; sample < samples.size(); ++sample) {
        const Point p = position_of(scan, samples[sample]);
        if (on_creases[sample] != 0) CHECK(sides_at(p, kSide) >= 2);
        corners += sides_at(p, kSide) == 3 ? 1u : 0u;
      }
      CHECK(corners == 8);
      const auto position = [&](std::uint64_t sample) {
        return position_of(scan, samples[sample]);
      };
      for (FaceId face = 0; face < base.face_count(); ++face)
        numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          const Point normal = area_vector(position(a), position(b), position(c));
          area += length(normal) / 2;
          volume += dot(position(a), normal) / 6;
        });
      CHECK(area == Approx((open ? 5 : 6) * kSide * kSide).epsilon(1e-12));
      if (!open) CHECK(volume == Approx(kSide * kSide * kSide).epsilon(1e-12));
    }
  }
}

}  // namespace plait::test
