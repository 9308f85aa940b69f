// A base mesh in files that is read by ranges says what one in memory says, keeps no array, and
// gives the same plan.
#include "parts/base_in_ranges.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "format/file_names.h"
#include "job_rules.h"
#include "laid_out_base.h"
#include "mesh/weld.h"
#include "plait/extend/parts.h"
#include "plait/job.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Names = std::vector<std::string>;

constexpr std::uint64_t kHardlyAny = 1 << 14, kMegabyte = 1 << 20;

std::vector<EarlierEdges> all_edges(const EdgesInOrder& edges) {
  std::vector<EarlierEdges> all;
  edges.each_run([&](EdgeId first, std::span<const EarlierEdges> run) {
    CHECK(first == all.size());
    all.insert(all.end(), run.begin(), run.end());
    return true;
  });
  return all;
}

void check_same(const Narrowing& found, const Narrowing& expected) {
  CHECK(found.moved == expected.moved);
  CHECK(found.merged == expected.merged);
  CHECK(found.outside == expected.outside);
  CHECK(found.farthest == expected.farthest);
  CHECK(found.share_of_edge == expected.share_of_edge);
  CHECK(found.coarse == expected.coarse);
  CHECK(found.largest_step == expected.largest_step);
  CHECK(found.finest_edge == expected.finest_edge);
}

/// `memory` is for the sorts.
void check_ranges(const IndexedMesh& mesh, std::uint64_t memory) {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  const BaseMesh whole = laid_out_at(path, mesh);
  BaseInRanges ranges(path, files.path() / "m.plan", memory);
  const std::uint64_t bytes_before = ranges.mesh().memory_bytes();
  CHECK(ranges.seam_vertices() == seam_vertices_of(whole));
  for (const int levels : {0, 3, 9})
    check_same(ranges.narrowing(levels), narrowing_of(whole.positions(), whole.faces(), levels));
  const EdgesInMemory expected(whole.topology());
  const std::unique_ptr<EdgesInOrder> found = ranges.edges();
  REQUIRE(found->count() == whole.edge_count());
  const std::vector<EarlierEdges> of_whole = all_edges(expected), of_ranges = all_edges(*found);
  REQUIRE(of_ranges.size() == of_whole.size());
  std::size_t same = 0;
  for (std::size_t edge = 0; edge < of_whole.size(); ++edge)
    if (std::minmax(of_whole[edge].a, of_whole[edge].b) ==
        std::minmax(of_ranges[edge].a, of_ranges[edge].b))
      ++same;
  CHECK(same == of_whole.size());
  std::uint64_t faces = 0;
  found->each_face([&](EdgesInOrder::Faces run) {
    CHECK(std::ranges::equal(run, whole.face_edges().subspan(faces, run.size())));
    faces += run.size();
  });
  CHECK(faces == whole.face_count());
  CHECK(ranges.mesh().memory_bytes() == bytes_before);  // nothing was kept
}

/// Moves vertices in all ways that float32 changes.
IndexedMesh with_hard_numbers(IndexedMesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  for (Vector3<double>& p : mesh.positions) {
    const auto kind = random() % 6;
    if (kind == 0) p = {p.x + 1e-9 * double(random() % 100), -0.0, p.z};
    if (kind == 1) p.x += 1e6;
    if (kind == 2) p.z = 1e39;
    if (kind == 3) p = {3 + 1e-12 * double(random() % 5), 0.0 * p.y, 7};  // some become one vertex
  }
  return mesh;
}

}  // namespace

TEST_CASE("A base mesh in ranges says what one in memory says") {
  SECTION("small meshes of all kinds") {
    for (const NamedMesh& named : all_meshes()) {
      INFO(named.name);
      check_ranges(named.mesh, kMegabyte);
    }
  }
  SECTION("hard numbers, seams and borders") {
    for (unsigned seed = 0; seed < 12; ++seed) {
      CAPTURE(seed);
      const IndexedMesh mesh = side_by_side({random_sphere(seed, 60), random_sheet(seed, 90),
                                             random_sheet(seed + 1, 40), open_fan(30)});
      check_ranges(shuffled(with_hard_numbers(mesh, seed), seed), kHardlyAny);
      IndexedMesh seams = mesh;
      for (Vector3<double>& p : seams.positions) p = {std::floor(2 * p.x), 0, -0.0};
      check_ranges(seams, kHardlyAny);
    }
  }
  SECTION("many runs of entries") {
    const std::uint32_t part = unless_sanitized(1u, 2u);
    check_ranges(
        shuffled(side_by_side({torus_grid(260 / part, 180 / part), sheet(150 / part, 150 / part)}),
                 5),
        kMegabyte);
  }
}

TEST_CASE("A plan of a base mesh that is larger than its memory is that of the whole mesh") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  IndexedMesh mesh = shuffled(side_by_side({torus_grid(120, 90), sheet(50, 40)}), 3);
  for (Vector3<double>& p : mesh.positions) p.x += 1e6;  // a warning of precision
  laid_out_at(path, mesh);
  PartsRequest request{
      .mesh = path, .plan = files.path() / "whole.plan", .parts = 40, .levels = 3, .normals = true};
  const PartsPlan whole = plan_parts(request, default_backends());
  request.plan = files.path() / "ranges.plan";
  request.memory_bytes = kMegabyte;
  REQUIRE(BaseInRanges::whole_bytes(path) > 2 * kMegabyte);
  Names when_asked;
  request.before_files = [&] { when_asked = Directory(files.path()).names(); };
  const PartsPlan ranges = plan_parts(request, default_backends());
  CHECK(when_asked == Names{"m.base", "whole.plan"});
  CHECK(Directory(files.path()).names() == Names{"m.base", "ranges.plan", "whole.plan"});
  CHECK_FALSE(whole.warnings.empty());
  REQUIRE(ranges.warnings.size() == whole.warnings.size());
  CHECK(ranges.warnings == whole.warnings);
  CHECK(ranges.files == whole.files);
  REQUIRE(ranges.memory);
  CHECK(ranges.memory->total_bytes == whole.memory->total_bytes);
  REQUIRE(ranges.parts.size() == whole.parts.size());
  for (std::size_t at = 0; at < whole.parts.size(); ++at) {
    CHECK(ranges.parts[at].first_edge == whole.parts[at].first_edge);
    CHECK(ranges.parts[at].edge_after == whole.parts[at].edge_after);
    CHECK(ranges.parts[at].records == whole.parts[at].records);
    CHECK(ranges.parts[at].faces == whole.parts[at].faces);
    CHECK(ranges.parts[at].ghosts == whole.parts[at].ghosts);
    CHECK(ranges.parts[at].seconds == whole.parts[at].seconds);
  }
  for (const std::uint32_t part : {0u, 17u, 39u})
    CHECK(make_part(request.plan, part, {}, default_backends()).digest ==
          make_part(files.path() / "whole.plan", part, {}, default_backends()).digest);
}

TEST_CASE("What a plan by ranges cannot do is refused, and damage is found") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  laid_out_at(path, shuffled(torus_grid(120, 90), 3));
  const PartsRequest request{.mesh = path,
                             .plan = files.path() / "m.plan",
                             .parts = 40,
                             .levels = 2,
                             .memory_bytes = kMegabyte};
  const auto check_refused = [&](const PartsRequest& asked, ErrorCode code, const char* says) {
    const Error error = error_of([&] { (void)plan_parts(asked, default_backends()); });
    CHECK(error.code() == code);
    CHECK_THAT(error.what(), Catch::Matchers::Contains(says));
    CHECK(Directory(files.path()).names() == Names{"m.base"});
  };
  PartsRequest other = request;
  other.layout = LayoutKind::kRcm;
  check_refused(other, ErrorCode::kBudget, "layout rcm");
  other = request;
  other.scheme = scheme_from_name("butterfly");
  check_refused(other, ErrorCode::kBudget, "butterfly");
  other = request;
  other.max_slot_bytes = 12;
  check_refused(other, ErrorCode::kBudget, "--max-slot");
  other = request;
  other.parts = 2;
  check_refused(other, ErrorCode::kBudget, "more than 2 parts");
  other = request;
  other.progress = [](const Progress& now) { return now.done < 2; };
  check_refused(other, ErrorCode::kCancelled, "cancelled");

  const std::uint64_t size = std::filesystem::file_size(path / kBaseIndexName);
  std::fstream index(path / kBaseIndexName, std::ios::binary | std::ios::in | std::ios::out);
  index.seekp(static_cast<std::streamoff>(size / 2));
  index.write("damage", 6);
  index.close();
  check_refused(request, ErrorCode::kCorruption, "checksum of the page");
}

TEST_CASE("The disk for sorts is said or refused before the work") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path out = files.path() / "m.plan";
  CHECK_FALSE(disk_for_sorts("plan", out, kMegabyte));
  const Error error = error_of([&] { (void)disk_for_sorts("plan m", out, 1ull << 60); });
  CHECK(error.code() == ErrorCode::kNoSpace);
  CHECK_THAT(error.what(), Catch::Matchers::Contains("plan m: until the end about"));
  // Of a mesh that the machine cannot have, so that sorts take more than any disk.
  const BaseCounts large{1ull << 50, 3ull << 50, 2ull << 50, 0};
  CHECK(code_of([&] {
          (void)disk_for_sorts("plan", out, BaseInRanges::disk_of_narrowing(large, kMegabyte));
        }) == ErrorCode::kNoSpace);
  CHECK(BaseInRanges::disk_of_narrowing({1000, 3000, 2000, 0}, kMegabyte) == 0);
  CHECK(BaseInRanges::disk_of_edges({1000, 3000, 2000, 0}, kMegabyte) == 3000 * 8);
  // A sort is in files exactly if it is said to be.
  const Directory directory(files.path());
  for (const std::uint64_t records : {100u, 128u, 129u, 1000u}) {
    const SortMemory memory{512, 128};
    ExternalSort<std::uint32_t> sort(directory, memory);
    for (std::uint32_t number = 0; number < records; ++number) sort.push(number);
    sort.sort();
    const std::uint64_t disk = disk_of_sort(records, sizeof(std::uint32_t), memory);
    CHECK((sort.merged_runs() > 0) == (disk > 0));
    if (sort.merged_runs() > 4) CHECK(disk == 2 * 4 * records);  // merged twice
  }
}

TEST_CASE("The option memory of a plan is for meshes that plait layout made") {
  const TemporaryDirectory files(Medium::kMemory);
  const std::filesystem::path path = files.path() / "m.base";
  laid_out_at(path, torus_grid(8, 7));
  const auto options = [&](const std::string& mesh, const std::string& memory) -> JobOptions {
    return {{"input", mesh},
            {"plan", (files.path() / "m.plan").native()},
            {"levels", "1"},
            {"parts", "2"},
            {"memory", memory}};
  };
  CHECK(code_of([&] {
          (void)run_job("plan", options((files.path() / "m.ply").native(), "1GiB"));
        }) == ErrorCode::kInvalidArgument);
  CHECK(code_of([&] { (void)run_job("plan", options(path.native(), "95MiB")); }) ==
        ErrorCode::kBudget);
  CHECK(Directory(files.path()).names() == Names{"m.base"});
  CHECK_NOTHROW((void)run_job("plan", options(path.native(), "96MiB")));
}

}  // namespace plait::test
