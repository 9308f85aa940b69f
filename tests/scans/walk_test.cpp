// Ways along a scan are straight: those of the plane, if the faces can be unfolded into it.
#include "sample/walk.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

Surface flat_sheet_scan() {
  IndexedMesh flat = sheet(20, 20);
  for (Point& p : flat.positions) p.z = 0;
  return repair(flat, {}, "mesh").surface;
}

SurfacePoint random_point(const Surface& scan, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const double root = std::sqrt(share(random)), v = share(random);
  return {static_cast<FaceId>(random() % scan.faces.size()), {1 - root, root * (1 - v), root * v}};
}

/// A flat sheet, and the same sheet bent along its second axis so that no edge changes its length.
struct BentSheet {
  Surface flat, bent;

  BentSheet() {
    IndexedMesh mesh = sheet(20, 20);
    for (Point& p : mesh.positions) p.z = 0;
    IndexedMesh rolled = mesh;
    for (Point& p : rolled.positions) {
      // Chords of a circle that are as long as the steps of the sheet.
      const double radius = 0.5 / std::sin(std::numbers::pi / 30);
      const double angle = p.x * std::numbers::pi / 15;
      p = {radius * std::sin(angle), p.y, radius * std::cos(angle)};
    }
    flat = repair(std::move(mesh), {}, "flat").surface;
    bent = repair(std::move(rolled), {}, "bent").surface;
  }
};

}  // namespace

TEST_CASE("Walk_OnFlatScan_EndsWhereTheVectorPoints") {
  const Surface scan = flat_sheet_scan();
  const SurfacePoint start{static_cast<FaceId>(scan.faces.size() / 2 + 10), {0.2, 0.3, 0.5}};
  const Point from = position_of(scan, start);
  const double edge = length(scan.corner(0, 1) - scan.corner(0, 0));
  for (int i = 0; i < 16; ++i) {
    const double angle = 0.4 * i;
    for (const double far : {0.05, 0.7, 3.3}) {
      const Point way{far * edge * std::cos(angle), far * edge * std::sin(angle), 0};
      CHECK(length(position_of(scan, walk(scan, start, way)) - (from + way)) < 1e-9 * edge);
    }
  }
  const SurfacePoint stopped = walk(scan, start, {1000 * edge, 0, 0});
  CHECK(std::min({stopped.weights[0], stopped.weights[1], stopped.weights[2]}) ==
        Approx(0).margin(1e-9));
}

TEST_CASE("Walk_OnABentSheet_GoesAsOnTheFlatOne") {
  const BentSheet sheets;
  REQUIRE(sheets.flat.faces == sheets.bent.faces);
  std::mt19937 random(3);
  std::size_t far = 0;
  for (int i = 0; i < 500; ++i) {
    const SurfacePoint start = random_point(sheets.flat, random);
    std::uniform_real_distribution<double> some(-4, 4);
    const std::array<double, 2> parts = {some(random), some(random)};
    const auto end_on = [&](const Surface& scan) {
      // The same way in both: by the sides of the first face.
      const Point a = scan.corner(start.face, 0);
      return walk(scan, start,
                  parts[0] * (scan.corner(start.face, 1) - a) +
                      parts[1] * (scan.corner(start.face, 2) - a));
    };
    const SurfacePoint flat = end_on(sheets.flat), bent = end_on(sheets.bent);
    // A way through a vertex may pass it on either side, so points are compared, not faces.
    CHECK(length(position_of(sheets.flat, flat) - position_of(sheets.flat, bent)) < 1e-6);
    far += flat.face != start.face ? 1u : 0u;
  }
  CHECK(far > 300);
}

TEST_CASE("Walk_OverAnEdge_KeepsItsLength") {
  // Two faces at a right angle.
  const Surface scan =
      repair({{{0, 0, 0}, {0, 4, 0}, {4, 2, 0}, {0, 2, 4}}, {{0, 2, 1}, {0, 1, 3}}}, {}, "mesh")
          .surface;
  const SurfacePoint start{0, {0.25, 0.5, 0.25}};  // (2, 2, 0)
  const Point end = position_of(scan, walk(scan, start, {-3, 0, 0}));
  CHECK(length(end - Point{0, 2, 1}) < 1e-9);
}

TEST_CASE("Walk_EveryWay_EndsInsideOfAFace") {
  std::mt19937 random(8);
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const Surface scan = repair(named.mesh, {}, "mesh").surface;
    std::uniform_real_distribution<double> some(-3, 3);
    std::size_t outside = 0;
    for (int i = 0; i < 200; ++i) {
      const SurfacePoint start = random_point(scan, random);
      const SurfacePoint end = walk(scan, start, {some(random), some(random), some(random)});
      const double sum = end.weights[0] + end.weights[1] + end.weights[2];
      if (end.face >= scan.faces.size() || std::abs(sum - 1) > 1e-9 ||
          !(std::min({end.weights[0], end.weights[1], end.weights[2]}) >= 0))
        ++outside;
    }
    CHECK(outside == 0);
  }
}

}  // namespace plait::test
