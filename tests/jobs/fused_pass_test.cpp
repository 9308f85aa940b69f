// Several iterations of a pass in one plan: the records are, bit by bit, those of as many passes
// one after another in one process, for any number of parts, iterations and levels.
#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "format/checksum.h"
#include "jobs/pass_surfaces.h"
#include "plait/compression.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "plait/extend/pass.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::passes {
namespace {

constexpr std::array<std::uint32_t, 5> kAllParts{1, 2, 3, 7, 16};
constexpr std::span<const std::uint32_t> kManyParts =
    std::span(kAllParts).subspan(unless_sanitized<std::size_t>(0, 3));
constexpr std::span<const std::uint32_t> kFewParts = std::span(kAllParts).subspan(3);

/// `on` as `iterations` passes of one process make it.
template <class Iterate>
Expected made_by_one(const Surfaces& on, std::uint32_t iterations, const Iterate& iterate) {
  on.make_whole();
  {
    Store store = open_to_write(on.whole());
    for (std::uint32_t pass = 0; pass < iterations; ++pass) iterate(store);
    store.commit();
  }
  return {digest_of(on.whole()), converted(on.whole())};
}

/// The same in parts and in one plan.
void check_fused(const Surfaces& on, const Expected& expected, std::uint32_t parts,
                 std::uint32_t iterations, const Pass& pass = kSmooth) {
  CAPTURE(parts, iterations);
  on.make_shards(parts);
  pass_in_parts(on, pass, parts % 2 == 0 ? 2 : 1, iterations);
  check_records(on, expected);
  CHECK(Store::open(on.sharded(), {}, default_backends()).sequence() == 2);
  std::filesystem::remove_all(on.sharded());
}

void check_smoothing(const Surfaces& on, const std::vector<std::uint32_t>& all_iterations,
                     std::span<const std::uint32_t> numbers = kManyParts) {
  for (const std::uint32_t iterations : all_iterations) {
    const Expected expected =
        made_by_one(on, iterations, [](Store& store) { smooth_simply(store, kSmooth.factor); });
    for (const std::uint32_t parts : numbers) check_fused(on, expected, parts, iterations);
    // run_pass() is that process too.
    std::filesystem::remove_all(on.whole());
    CHECK(made_by_one(on, iterations, [](Store& store) { run_pass(store, kSmooth); }).digest ==
          expected.digest);
    std::filesystem::remove_all(on.whole());
  }
}

Pass height_pass() {
  Pass pass;
  pass.name = "height";
  pass.result = schema_of<float>("height");
  pass.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(store, options, std::tuple{reads<Point>("position"), overwrites<float>(into)},
                   [](const VertexRun&, std::span<const Point> at, std::span<float> to) {
                     for (std::size_t i = 0; i < at.size(); ++i) to[i] = at[i].z;
                   });
  };
  return pass;
}

/// Needs neighbours of what it replaces, another attribute, and the number of each vertex.
Pass spread_pass() {
  Pass pass = height_pass();
  pass.name = "spread";
  pass.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(
        store, options,
        std::tuple{rings_of<float>("height"), rings_of<Point>("position"), overwrites<float>(into)},
        [](const VertexRun& run, const VertexRings<float>& height,
           const VertexRings<Point>& position, std::span<float> to) {
          for (std::size_t i = 0; i < run.count; ++i) {
            float sum = height.vertex(i);
            for (int k = 0; k < height.valence(); ++k)
              sum += height.neighbour(i, k) * position.neighbour(i, k).x;
            to[i] = 0.125f * sum + static_cast<float>((run.first + i) % 7);
          }
        });
  };
  return pass;
}

/// The names in the directory of a part, without those that every part has.
std::set<std::string> names_in(const std::filesystem::path& directory) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    names.insert(entry.path().filename());
  return names;
}

/// The plan's file with another number of iterations, the last one in it, and the right checksum.
void forge_iterations(const std::filesystem::path& plan, std::uint32_t iterations) {
  std::string bytes = bytes_of(plan / "plan");
  const std::size_t end = bytes.size() - sizeof(std::uint64_t);
  std::memcpy(bytes.data() + end - sizeof iterations, &iterations, sizeof iterations);
  const std::uint64_t checksum = checksum_of(std::as_bytes(std::span(bytes)).first(end));
  std::memcpy(bytes.data() + end, &checksum, sizeof checksum);
  std::ofstream(plan / "plan", std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("FusedPass_SmoothingInAnyNumberOfParts_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  SECTION("a mesh with border, refined in memory first") {
    check_smoothing(surfaces_of(here.path(), random_sheet(5, 60)), {1, 2, 3, 5});
  }
  SECTION("a closed mesh with slots of its own base mesh") {
    Surfaces on = surfaces_of(here.path(), random_sphere(3, 80));
    on.max_slot_bytes = std::nullopt;
    check_smoothing(on, {1, 2, 3, 5});
  }
  SECTION("several components, some closed and some with border") {
    Surfaces on =
        surfaces_of(here.path(), side_by_side({random_sheet(2, 20), random_torus(4, 20),
                                               tetrahedron(), single_triangle(), closed_fan(9)}));
    on.max_slot_bytes = std::nullopt;
    on.levels = 2;
    check_smoothing(on, {2, 3, 5, 6});
  }
}

// With n steps along an edge of the base mesh, n + 1 iterations need one ring of faces, 2 n + 1
// two.
TEST_CASE("FusedPass_MoreIterationsThanStepsAlongAnEdge_ReadsMoreRings") {
  const TemporaryDirectory here(Medium::kMemory);
  SECTION("two steps") {
    Surfaces on = surfaces_of(here.path(), torus_grid(9, 8));
    on.max_slot_bytes = std::nullopt;
    on.levels = 1;
    check_smoothing(on, {2, 3, 4, 5, 6, 7, 8}, kFewParts);
  }
  SECTION("two steps, with border") {
    Surfaces on = surfaces_of(here.path(), random_sheet(7, 90));
    on.max_slot_bytes = std::nullopt;
    on.levels = 1;
    check_smoothing(on, {3, 4, 5, 6, 9}, kFewParts);
  }
  SECTION("four steps") {
    Surfaces on = surfaces_of(here.path(), sheet(12, 10));
    on.max_slot_bytes = std::nullopt;
    on.levels = 2;
    check_smoothing(on, {4, 5, 6, 9, 10}, kFewParts);
  }
}

TEST_CASE("FusedPass_CompressedShardsAndLittleMemory_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.max_slot_bytes = std::nullopt;
  on.levels = 4;
  on.pipeline_of = [](const AttributeSchema& schema) {
    return LevelPipelines(preset_pipeline("fast", schema));
  };
  const Expected expected =
      made_by_one(on, 5, [](Store& store) { smooth_simply(store, kSmooth.factor); });
  on.make_shards(3);
  const std::filesystem::path plan = on.plan(kSmooth, "plan", 5);
  const Error error = error_of([&] { make_parts(plan, kSmooth, 1, 64 << 10); });
  CHECK(error.code() == ErrorCode::kBudget);
  make_parts(plan, kSmooth, 2, 448 << 10);
  REQUIRE(join(plan, on.sharded()).has_store);
  CHECK(digest_of(on.sharded()) == expected.digest);
}

TEST_CASE("FusedPass_Noise_IsThatOfSeveralPlans") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.precision = ComponentType::kFloat64;
  const Pass noise{.name = "noise", .amplitude = 1e-3, .seed = 7, .diagonal = 5.5};
  const Expected expected = made_by_one(on, 4, [&](Store& store) { run_pass(store, noise); });
  for (const std::uint32_t parts : kManyParts) check_fused(on, expected, parts, 4, noise);
  // It reads no neighbours, so it reads no halo.
  on.make_shards(7);
  const PartsPlan one = read_parts_plan(on.plan(noise, "1")),
                  four = read_parts_plan(on.plan(noise, "4", 4)),
                  smooth = read_parts_plan(on.plan(kSmooth, "smooth", 4));
  for (std::size_t part = 0; part < 7; ++part) {
    CHECK(four.parts[part].ghosts == one.parts[part].ghosts);
    CHECK(four.parts[part].seconds > 3.9 * one.parts[part].seconds);
    CHECK(smooth.parts[part].ghosts > one.parts[part].ghosts);
    CHECK(smooth.parts[part].records == one.parts[part].records);
  }
  CHECK(smooth.pass->iterations == 4);
}

TEST_CASE("FusedPass_OfTheProgramsOwn_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.normals = true;
  const Expected expected = made_by_one(on, 1, [](Store& store) {
    run_pass(store, height_pass());
    for (int pass = 0; pass < 3; ++pass) run_pass(store, spread_pass());
  });
  for (const std::uint32_t parts : kManyParts) {
    CAPTURE(parts);
    on.make_shards(parts);
    pass_in_parts(on, height_pass());
    pass_in_parts(on, spread_pass(), 2, 3);
    check_records(on, expected);
    std::filesystem::remove_all(on.sharded());
  }
}

// What is computed nowhere in the part has the values of the last commit in all iterations: a
// kernel never gets anything else, not even where the result will not be used.
TEST_CASE("FusedPass_KernelAtTheEdgeOfTheHalo_ReadsOnlyValuesOfTheAttribute") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), torus_grid(12, 11));
  on.max_slot_bytes = std::nullopt;
  on.levels = 2;
  on.make_shards(7);
  Pass ones = height_pass();
  ones.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(store, options, std::tuple{overwrites<float>(into)},
                   [](const VertexRun&, std::span<float> to) { std::ranges::fill(to, 1.0f); });
  };
  pass_in_parts(on, ones);
  std::atomic<std::uint64_t> visited = 0, others = 0;
  Pass check = height_pass();
  check.name = "check";
  check.kernel = [&](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(
        store, options, std::tuple{rings_of<float>("height"), overwrites<float>(into)},
        [&](const VertexRun& run, const VertexRings<float>& height, std::span<float> to) {
          for (std::size_t i = 0; i < run.count; ++i) {
            to[i] = height.vertex(i);
            others += to[i] != 1;
            for (int k = 0; k < height.valence(); ++k) others += height.neighbour(i, k) != 1;
          }
          visited += run.count;
        });
  };
  pass_in_parts(on, check, 1, 8);
  CHECK(others == 0);
  const Store store = Store::open(on.sharded(), {}, default_backends());
  CHECK(visited > 8 * counts_at_level(store.base(), 2).vertices);
}

TEST_CASE("FusedPart_WhatItComputesForItself_IsRemoved") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  pass_in_parts(on, height_pass());
  const std::filesystem::path one = on.plan(spread_pass(), "one"),
                              three = on.plan(spread_pass(), "three", 3);
  for (const std::filesystem::path& plan : {one, three}) make_parts(plan, spread_pass());
  for (std::uint32_t part = 0; part < 3; ++part)
    CHECK(names_in(directory_of(one, part)) == names_in(directory_of(three, part)));
  // Also after an error in the last iteration.
  const std::set<std::string> before = names_in(three);
  int calls = 0;
  PartOptions options;
  options.again = true;
  options.kernel = [&](Store& store, const std::string& into, const VisitOptions& how) {
    spread_pass().kernel(store, into, how);
    if (++calls == 3) throw Error(ErrorCode::kCancelled, "stopped by the kernel");
  };
  CHECK_THAT(error_of([&] { make_part(three, 1, options, default_backends()); }).what(),
             Catch::Contains("stopped by the kernel"));
  CHECK(calls == 3);
  CHECK(names_in(three) == before);
}

TEST_CASE("FusedPass_ThatCannotBeIterated_IsRefusedInWords") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.max_slot_bytes = std::nullopt;
  on.levels = 1;
  on.make_shards(3);
  const auto refused = [&](const Pass& pass, std::uint32_t iterations) {
    const Error error = error_of([&] { on.plan(pass, "refused", iterations); });
    CHECK_FALSE(std::filesystem::exists(here.path() / "refused"));
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return std::string(error.what());
  };
  CHECK_THAT(refused({.name = "normals"}, 2), Catch::Contains("one is enough"));
  CHECK_THAT(refused({.name = "noise"}, 2), Catch::Contains("give the diagonal"));
  CHECK_THAT(refused(height_pass(), 2), Catch::Contains("has no 'height'"));
  CHECK_THAT(refused(kSmooth, 0), Catch::Contains("expected 1 to 1000"));
  CHECK_THAT(refused(kSmooth, 1001), Catch::Contains("expected 1 to 1000"));
  CHECK_THAT(refused(kSmooth, 34), Catch::Contains("17 rings"));
  CHECK_THAT(refused(kSmooth, 34), Catch::Contains("at most 33"));
  on.plan(kSmooth, "most", 33);
}

TEST_CASE("FusedPlan_HostileNumberOfIterations_IsDamageOfThePlan") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const std::filesystem::path smooth = on.plan(kSmooth, "smooth", 3),
                              normals = on.plan({.name = "normals"}, "normals");
  CHECK(read_parts_plan(smooth).pass->iterations == 3);
  const auto damaged = [&](const std::filesystem::path& plan) {
    for (const auto& call : std::initializer_list<std::function<void()>>{
             [&] { read_parts_plan(plan); }, [&] { make_part(plan, 1, {}, default_backends()); },
             [&] { join(plan, on.sharded()); }}) {
      const Error error = error_of(call);
      CHECK(error.code() == ErrorCode::kCorruption);
      CHECK_THAT(error.what(), Catch::Contains("number of iterations"));
    }
  };
  for (const std::uint32_t iterations : {0u, 1001u, 0x80000000u, 0xffffffffu}) {
    forge_iterations(smooth, iterations);
    damaged(smooth);
  }
  forge_iterations(normals, 2);
  damaged(normals);
  forge_iterations(smooth, 3);
  make_parts(smooth);
  CHECK(join(smooth, on.sharded()).has_store);
}

}  // namespace plait::test::passes
