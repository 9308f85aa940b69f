// remesh() with a largest distance: each face keeps the levels that it needs, and what is drawn is
// as near to the scan as was asked for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "compare/triangles.h"
#include "distance/distances.h"
#include "jobs/remesh_files.h"
#include "plait/digest.h"
#include "plait/verify.h"
#include "prune/compare_pruned.h"
#include "remesh/tolerance_search.h"
#include "support/error_of.h"
#include "support/sanitized.h"

namespace plait::test::remesh_depths_test {
namespace {

/// Flat but for a bump in the middle.
IndexedMesh bump() {
  IndexedMesh mesh = flat_sheet(60, 60);
  for (Vector3<double>& p : mesh.positions) {
    const double x = p.x - 30, y = p.y - 30;
    p.z = 6 * std::exp(-(x * x + y * y) / 30);
  }
  return mesh;
}

/// By other points than those of the report.
double measured(const IndexedMesh& from, const IndexedMesh& to) {
  const TriangleSet a{from.positions, from.faces}, b{to.positions, to.faces};
  return measure_distances(a, TriangleTree(b.positions, b.faces), b, {.samples = 200000}).max;
}

}  // namespace

TEST_CASE("Remesh_LargestDistance_LeavesTheLevelsThatFacesNeed") {
  for (const IndexedMesh& mesh :
       {bump(), torus_grid(unless_sanitized(80, 40), unless_sanitized(60, 30))}) {
    const RemeshFiles files;
    write_with_attributes(files.scan, mesh);
    RemeshRequest request = files.request(0, 4);
    request.max_distance = RelativeLength{.number = 0.3, .is_percent = true};
    request.digest = true;
    const RemeshReport report = files.run(request);
    CHECK(report.vertices < report.from_vertices);
    CHECK(report.small_faces < report.from_faces);
    CHECK(report.tolerance <= report.max_distance);
    CHECK(report.to_store.max <= report.max_distance);
    CHECK(report.to_scan.max <= report.max_distance);
    {
      const Store store = files.open();
      REQUIRE(store.has_depths());
      CHECK(counts_at_level(store.base(), report.levels).vertices == report.vertices);
      CHECK(counts_at_level(store.base(), report.levels).faces == report.small_faces);
      std::vector<std::uint64_t> faces(static_cast<std::size_t>(report.levels) + 1);
      for (FaceId face = 0; face < store.base().face_count(); ++face) {
        ++faces[static_cast<std::size_t>(store.depth(face))];
        for (int side = 0; side < 3; ++side)
          if (const FaceSide beyond = store.base().topology().across(FaceSide(face, side));
              beyond.exists())
            CHECK(std::abs(store.depth(face) - store.depth(beyond.face())) <= 1);
      }
      CHECK(faces == report.faces_of_level);
      CHECK(verify(store).damaged.empty());
    }
    const IndexedMesh drawn = read_triangles(files.store, -1, default_backends(), {}),
                      scan = read_triangles(files.scan, -1, default_backends(), {});
    CHECK(drawn.faces.size() == report.small_faces);
    CHECK(measured(scan, drawn) <= report.max_distance);
    CHECK(measured(drawn, scan) <= report.max_distance);

    // The same bits by one thread, and those of the store of all levels, attributes of the scan
    // too.
    request.threads = 1;
    CHECK(files.run(request).digest == report.digest);
    request.store = files.directory.path() / "uniform.plait";
    request.own_depths = false;
    const RemeshReport uniform = files.run(request);
    const Store store = files.open(), all = Store::open(request.store, {}, default_backends());
    CHECK_FALSE(all.has_depths());
    CHECK(uniform.vertices == report.from_vertices);
    CHECK(uniform.from_vertices == report.from_vertices);
    CHECK(uniform.faces_of_level.empty());
    CHECK(store.attributes().size() == all.attributes().size());
    CHECK(store.has_attribute("height"));
    CHECK(compare_pruned(store, all).difference.value_or("") == "");
  }
}

TEST_CASE("Remesh_WithDepthsAndWithoutADistance_IsRefused") {
  const RemeshFiles files;
  write_ply(files.scan, torus_grid(20, 20));
  RemeshRequest request = files.request(60);
  request.own_depths = true;
  CHECK(error_of([&] { files.run(request); }).code() == ErrorCode::kInvalidArgument);
  CHECK_FALSE(std::filesystem::exists(files.store));
  request.own_depths = false;
  CHECK(files.run(request).vertices > 0);
}

TEST_CASE("Remesh_Cancelled_WhileDepthsAreChosen_LeavesNothing") {
  const RemeshFiles files;
  write_ply(files.scan, bump());
  RemeshRequest request = files.request(0, 4);
  request.max_distance = RelativeLength{.number = 0.3, .is_percent = true};
  std::uint64_t last = 0;
  bool ascends = true;
  const JobWatch watch{.progress = [&](const Progress& now) {
    ascends &= now.done >= last;
    last = now.done;
    return now.done < 725;
  }};
  CHECK(error_of([&] { files.run(request, watch); }).code() == ErrorCode::kCancelled);
  CHECK(ascends);
  CHECK_FALSE(std::filesystem::exists(files.store));
}

TEST_CASE("ToleranceSearch_OfDistancesThatAddUp_ComesWithinTheLimit") {
  for (const double all_levels : {0.0, 0.3, 0.7, 0.99, 1.0})
    for (const double share : {0.2, 0.6, 1.0}) {
      CAPTURE(all_levels, share);
      ToleranceSearch search(1, all_levels);
      CHECK(search.tolerance() == 1);
      int trials = 1;
      for (double before = 1; all_levels + share * search.tolerance() > 1; ++trials) {
        search.next(all_levels + share * search.tolerance());
        CHECK(search.tolerance() < before);
        before = search.tolerance();
      }
      CHECK(trials <= 7);
      // What is not needed is not given away.
      if (all_levels < 0.99 && share == 1.0)
        CHECK(all_levels + share * search.tolerance() > 0.2 + 0.7 * all_levels);
    }
}

}  // namespace plait::test::remesh_depths_test
