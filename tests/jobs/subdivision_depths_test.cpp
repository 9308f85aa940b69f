// subdivide with a largest distance: the store is the one that prune makes of all levels, which are
// never there under its name.
#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <string>

#include "compare/triangles.h"
#include "distance/distances.h"
#include "jobs/pruned_stores.h"
#include "plait/digest.h"
#include "plait/subdivision_job.h"
#include "prune/compare_pruned.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::subdivision_depths_test {
namespace {

/// Flat but for one corner.
IndexedMesh corner() {
  IndexedMesh mesh = sheet(8, 8);
  for (Vector3<double>& at : mesh.positions) at.z = 0;
  mesh.positions.back().z = 1;
  return mesh;
}

SubdivisionRequest request_for(const IndexedMesh& mesh, const std::filesystem::path& store) {
  return {.mesh = BaseMesh::build(mesh),
          .store = store,
          .levels = 4,
          .backend = "pread",
          .normals = true,
          .durability = Durability::kNone,
          .digest = true};
}

SubdivisionResult run(const SubdivisionRequest& request, const JobWatch& watch = {}) {
  return SubdivisionJob(request, default_backends()).run(watch);
}

std::size_t entries(const std::filesystem::path& directory) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory),
                                                std::filesystem::directory_iterator()));
}

double measured(const IndexedMesh& from, const IndexedMesh& to) {
  const TriangleSet a{from.positions, from.faces}, b{to.positions, to.faces};
  return measure_distances(a, TriangleTree(b.positions, b.faces), b, {.samples = 100000}).max;
}

}  // namespace

TEST_CASE("Subdivide_WithALargestDistance_MakesWhatPruneLeaves") {
  for (const IndexedMesh& mesh : {corner(), random_sphere(6, 60)})
    for (const bool compressed : {false, true})
      for (const std::uint64_t max_slot : {std::uint64_t{16} << 10, std::uint64_t{100}}) {
        CAPTURE(compressed, max_slot);
        const TemporaryDirectory directory{Medium::kMemory};
        const auto whole = directory.path() / "whole", near = directory.path() / "near";
        SubdivisionRequest request = request_for(mesh, whole);
        request.max_slot_bytes = max_slot;
        if (compressed) {
          request.backend = "compressed";
          request.pipeline_of = [](const AttributeSchema& schema) {
            Compression compression;
            compression.add("default");
            return compression.pipeline_of(schema);
          };
        }
        run(request);
        const PruneResult pruned_ = pruned(whole, directory.path() / "pruned", 1, "0.2%");
        request.store = near;
        request.max_distance = 0.002;
        request.distance_in_diagonals = true;
        const SubdivisionResult result = run(request);
        CHECK(entries(directory.path()) == 3);
        CHECK(result.store == near);

        const Store store = open(near), all = open(whole);
        REQUIRE(store.has_depths());
        CHECK(result.digest == digest(open(directory.path() / "pruned")).to_string());
        CHECK(compare_pruned(store, all).difference.value_or("") == "");
        CHECK(store.options().backend == *request.backend);
        CHECK(store.provenance().scheme == all.provenance().scheme);
        CHECK(result.distance == *pruned_.distance);
        CHECK(std::ranges::equal(
            result.faces_of_level,
            std::span(pruned_.faces_of_level).first(result.faces_of_level.size())));
        CHECK(result.drawn.vertices ==
              counts_at_level(store.base(), 4 - store.base_level()).vertices);
        CHECK(result.drawn.vertices < result.plan.level_counts.back().vertices);
        if (compressed) continue;
        const IndexedMesh drawn = read_triangles(near, -1, default_backends(), {}),
                          fine = read_triangles(whole, -1, default_backends(), {});
        CHECK(drawn.faces.size() == result.drawn.faces);
        CHECK(measured(drawn, fine) <= *pruned_.tolerance);
        CHECK(measured(fine, drawn) <= *pruned_.tolerance);
      }
}

TEST_CASE("Subdivide_WithALargestDistance_ReplacesAStoreOrLeavesNothing") {
  const TemporaryDirectory directory;
  SubdivisionRequest request = request_for(corner(), directory.path() / "near");
  request.max_distance = 0.01;
  const std::string first = run(request).digest;
  CHECK(error_of([&] { run(request); }).code() == ErrorCode::kInvalidArgument);
  request.existing = Existing::kReplace;
  CHECK(run(request).digest == first);
  CHECK(entries(directory.path()) == 1);
  for (const std::string step : {"levels", "distances", "copy", "digest"}) {
    CAPTURE(step);
    bool reached = false;
    const JobWatch watch{.step = [&](std::string_view now) { reached |= now == step; },
                         .progress = [&](const Progress&) { return !reached; }};
    CHECK(error_of([&] { run(request, watch); }).code() == ErrorCode::kCancelled);
    CHECK(reached);
    CHECK(entries(directory.path()) == 1);
    CHECK(digest(open(request.store)).to_string() == first);
  }
}

TEST_CASE("Subdivide_WithALargestDistanceAndWhatItCannotHave_IsRefused") {
  const TemporaryDirectory directory;
  const auto refused = [&](auto change, const std::string& option) {
    SubdivisionRequest request = request_for(corner(), directory.path() / "near");
    request.max_distance = 0.01;
    change(request);
    const SubdivisionJob job(request, default_backends());
    REQUIRE(job.plan().refusals.size() == 1);
    CHECK(job.plan().refusals[0].option == option);
    CHECK(entries(directory.path()) == 0);
  };
  refused([](SubdivisionRequest& r) { r.resume = true; }, "resume");
  refused([](SubdivisionRequest& r) { r.backend = "memory"; }, "backend");
  refused([](SubdivisionRequest& r) { r.max_distance = -1; }, "max-distance");
}

}  // namespace plait::test::subdivision_depths_test
