// Passes over a store in shards, in parts: the same records, digests and bytes as one process makes
// over a store in one piece; what is stale, foreign, forged or damaged is refused in words.
#include "plait/extend/pass.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "format/checksum.h"
#include "io/file_operations.h"
#include "jobs/pass_surfaces.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/check_store.h"
#include "plait/extend/directory.h"
#include "plait/extend/parts.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "store/old_versions.h"
#include "support/error_of.h"
#include "support/file_bytes.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::passes {
namespace {

using Numbers = std::vector<std::uint32_t>;

void check_smoothing(const Surfaces& on, const Expected& expected, std::uint32_t parts,
                     int iterations = kIterations) {
  CAPTURE(parts);
  on.make_shards(parts);
  for (int pass = 0; pass < iterations; ++pass) pass_in_parts(on, kSmooth, pass % 2 + 1);
  check_records(on, expected);
  fs::remove_all(on.sharded());
}

Error part_error(const fs::path& plan, std::uint32_t part) {
  return error_of([&] { make_part(plan, part, {.again = true}, default_backends()); });
}

/// Gives a file of a plan with other bytes the right checksum.
std::string sealed(std::string bytes) {
  const std::size_t end = bytes.size() - sizeof(std::uint64_t);
  const std::uint64_t checksum = checksum_of(std::as_bytes(std::span(bytes)).first(end));
  std::memcpy(bytes.data() + end, &checksum, sizeof checksum);
  return bytes;
}

}  // namespace

TEST_CASE("PassInParts_IterationsOfSmoothing_GiveTheRecordsOfOneProcess", "[threads]") {
  const TemporaryDirectory here(Medium::kMemory);
  SECTION("a mesh with border, refined in memory first") {
    const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
    const Expected expected = smoothed_by_one(on);
    for (const std::uint32_t parts : unless_sanitized(Numbers{1, 2, 3, 7, 16, 64}, Numbers{2, 7}))
      check_smoothing(on, expected, parts);
  }
  SECTION("a closed mesh with slots of its own base mesh") {
    Surfaces on = surfaces_of(here.path(), random_sphere(3, 80));
    on.max_slot_bytes = std::nullopt;
    const Expected expected = smoothed_by_one(on);
    for (const std::uint32_t parts : unless_sanitized(Numbers{2, 16}, Numbers{3}))
      check_smoothing(on, expected, parts);
  }
  SECTION("more parts than are open at once, one iteration") {
    Surfaces on = surfaces_of(here.path(), random_sheet(9, unless_sanitized(900u, 300u)));
    on.levels = 2;
    on.max_slot_bytes = std::nullopt;
    check_smoothing(on, smoothed_by_one(on, 1), unless_sanitized(200u, 70u), 1);
  }
}

TEST_CASE("PassInParts_OnCompressedShards_GivesTheRecordsOfOneProcess") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.pipeline_of = [](const AttributeSchema& schema) {
    return LevelPipelines(preset_pipeline("fast", schema));
  };
  const Expected expected = smoothed_by_one(on);
  on.make_shards(7);
  for (int pass = 0; pass < kIterations; ++pass) pass_in_parts(on, kSmooth);
  CHECK(digest_of(on.sharded()) == expected.digest);
}

TEST_CASE("PassInParts_Noise_MovesVerticesAsOneProcessDoes") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  for (const ComponentType precision : {ComponentType::kFloat32, ComponentType::kFloat64}) {
    on.precision = precision;
    on.make_whole();
    const Pass noise{.name = "noise", .amplitude = 1e-3, .seed = 7};
    PassFigures figures;
    {
      Store store = open_to_write(on.whole());
      figures = run_pass(store, noise);
      store.commit();
    }
    on.make_shards(7);
    const fs::path plan = on.plan(noise);
    CHECK(read_parts_plan(plan).pass->pass.diagonal == figures.diagonal);
    make_parts(plan);
    REQUIRE(join(plan, on.sharded()).has_store);
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    const Store store = Store::open(on.sharded(), {}, default_backends());
    CHECK(store.sequence() == 2);
    CHECK(store.provenance().scheme.empty());
    for (const char* const made : {"plan", "s.plait", "whole.plait"})
      fs::remove_all(here.path() / made);
  }
}

TEST_CASE("PassInParts_Normals_AreThoseOfSubdivision", "[threads]") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  for (const std::uint32_t parts : {1u, 7u}) {
    on.normals = false;
    on.make_shards(parts);
    pass_in_parts(on, {.name = "normals"}, 2);
    on.normals = true;
    on.make_whole();
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    CHECK(converted(on.sharded()) == converted(on.whole()));
    // Again: now they replace normals.
    pass_in_parts(on, {.name = "normals"});
    CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
    fs::remove_all(on.sharded());
    fs::remove_all(on.whole());
  }
}

TEST_CASE("PassInParts_OfTheProgramsOwn_GivesTheRecordsOfOneProcess", "[threads]") {
  const TemporaryDirectory here(Medium::kMemory);
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.normals = true;
  on.make_whole();
  {
    Store store = open_to_write(on.whole());
    run_pass(store, own_pass());
    store.commit();
  }
  on.make_shards(5);
  const fs::path plan = on.plan(own_pass());
  const PartsPlan known = read_parts_plan(plan);
  REQUIRE(known.pass);
  CHECK(known.pass->pass.parameters == "weight 2");
  CHECK(known.pass->result == schema_of<float>("relief"));
  CHECK(error_of([&] { make_parts(plan); }).code() == ErrorCode::kInvalidArgument);
  make_parts(plan, own_pass(), 2);
  REQUIRE(join(plan, on.sharded()).has_store);
  CHECK(digest_of(on.sharded()) == digest_of(on.whole()));
  CHECK(converted(on.sharded()) == converted(on.whole()));
}

TEST_CASE("PassInParts_KernelThatReadsNoRingsOrThrows_IsAnotherProgramsMatter") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sphere(3, 80));
  on.make_shards(3);
  Pass pass{.name = "height", .result = schema_of<float>("height")};
  std::uint64_t base_runs = 0, base_vertices = 0;
  pass.kernel = [&](Store& store, const std::string& into, const VisitOptions& options) {
    visit_vertices(store, options, std::tuple{reads<Point>("position"), overwrites<float>(into)},
                   [&](const VertexRun& run, std::span<const Point> at, std::span<float> to) {
                     if (run.is_base()) ++base_runs, base_vertices += run.count;
                     for (std::size_t i = 0; i < run.count; ++i) to[i] = at[i].z;
                   });
  };
  const fs::path plan = on.plan(pass);
  make_parts(plan, pass);
  const Store before = Store::open(on.sharded(), {}, default_backends());
  CHECK(base_vertices == before.base().vertex_count());
  CHECK(base_runs < base_vertices);
  Pass failing = pass;
  failing.kernel = [](Store&, const std::string&, const VisitOptions&) {
    throw Error(ErrorCode::kCancelled, "stopped by the kernel");
  };
  CHECK_THAT(error_of([&] {
               make_part(plan, 1, {.again = true, .kernel = failing.kernel}, default_backends());
             }).what(),
             Catch::Contains("stopped by the kernel"));
  REQUIRE(join(plan, on.sharded()).has_store);  // what was done before stays done
  const Store after = Store::open(on.sharded(), {}, default_backends());
  const auto heights = after.base_records<float>(after.attribute("height"));
  const auto positions = after.base_records<Point>(after.attribute("position"));
  for (std::size_t vertex = 0; vertex < heights.size(); ++vertex)
    CHECK(heights[vertex] == positions[vertex].z);
}

TEST_CASE("PassJoin_ReadersOfTheVersionBefore_KeepIt") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(4);
  const std::string first = digest_of(on.sharded());
  {
    const Store reader = Store::open(on.sharded(), {}, default_backends());
    pass_in_parts(on, kSmooth);
    CHECK(digest(reader).to_string() == first);
    CHECK(digest_of(on.sharded()) != first);
  }
  pass_in_parts(on, kSmooth);
  for (const auto& entry : fs::directory_iterator(on.sharded()))
    CHECK_FALSE(entry.path().filename().native().starts_with("attribute0.level"));
}

TEST_CASE("PassPart_ItsFiles_AreTheOnlyOnesItChanges") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan(kSmooth);
  make_part(plan, 0, {}, default_backends());
  check_that_a_part_changes_only_its_files(plan);
}

TEST_CASE("PassPlan_ThatDoesNotFit_IsRefusedAndLeavesNothing") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  on.make_whole();
  const auto refused = [&](const fs::path& store, const Pass& pass) {
    const PassRequest request{.store = store, .plan = here.path() / "refused", .pass = pass};
    const Error error = error_of([&] { plan_pass(request, default_backends()); });
    CHECK_FALSE(fs::exists(request.plan));
    return error;
  };
  CHECK(refused(on.whole(), kSmooth).code() == ErrorCode::kNotSupported);
  CHECK_THAT(refused(on.whole(), kSmooth).what(), Catch::Contains("in one piece"));
  CHECK(refused(here.path() / "none", kSmooth).code() == ErrorCode::kNotFound);
  for (const Pass& pass :
       {Pass{.name = "polish"}, Pass{.factor = 1.5}, Pass{.factor = -1},
        Pass{.name = "noise", .amplitude = 2}, Pass{.name = "noise", .diagonal = -1},
        Pass{.name = "own", .result = schema_of<double>("position")},
        Pass{.name = "a b", .result = schema_of<float>("x")},
        Pass{.name = "own", .result = schema_of<float>("x y")}}) {
    CAPTURE(pass.name, pass.result.name);
    CHECK(refused(on.sharded(), pass).code() == ErrorCode::kInvalidArgument);
  }
  const fs::path plan = on.plan(kSmooth);
  CHECK(error_of([&] {
          plan_pass({.store = on.sharded(), .plan = plan, .pass = {}}, default_backends());
        }).code() == ErrorCode::kInvalidArgument);
}

TEST_CASE("PassJoin_PartsMissingWrongOrStale_NamesThemByNumber") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  constexpr std::uint32_t kParts = 6;
  on.make_shards(kParts);
  const std::string before = digest_of(on.sharded());
  const fs::path plan = on.plan(kSmooth);
  const auto wrong = [&](const JoinOptions& options = {}) {
    const JoinResult joined = join(plan, on.sharded(), options);
    CHECK_FALSE(joined.has_store);
    CHECK(digest_of(on.sharded()) == before);
    return joined;
  };
  for (const std::uint32_t part : {0u, 2u}) make_part(plan, part, {}, default_backends());
  CHECK(wrong().again() == "1,3-5");
  make_parts(plan);
  SECTION("files are cut or missing") {
    const fs::path level = directory_of(plan, 3) / "attribute1.levels.2.shard3";
    fs::resize_file(level, fs::file_size(level) - 1);
    fs::remove(directory_of(plan, 4) / "version.2.shard4");
    fs::resize_file(plan / "done.5", fs::file_size(plan / "done.5") - 1);
    fs::remove(plan / "done.0");
    const JoinResult joined = wrong();
    CHECK(joined.bad == Numbers{3, 4, 5});
    CHECK(joined.again() == "0,3-5");
    make_parts(plan);
    CHECK(join(plan, on.sharded()).has_store);
  }
  SECTION("a block is damaged, which only --verify reads") {
    const fs::path file = directory_of(plan, 5) / "attribute1.levels.2.shard5";
    flip_byte(file, 40);
    CHECK(wrong({.verify = true}).bad == Numbers{5});
  }
  SECTION("the store is another one, or has another version") {
    fs::create_directory(here.path() / "else");
    const Surfaces other = surfaces_of(here.path() / "else", random_sheet(5, 60));
    other.make_shards(kParts);
    const Error foreign = error_of([&] { join(plan, other.sharded()); });
    CHECK(foreign.code() == ErrorCode::kBadState);
    CHECK_THAT(foreign.what(), Catch::Contains("another store"));
    const fs::path same = on.plan(kSmooth, "same"), stale = on.plan(kSmooth, "stale");
    make_part(stale, 1, {}, default_backends());
    REQUIRE(join(plan, on.sharded()).has_store);
    CHECK(join(plan, on.sharded()).has_store);  // it is joined already
    CHECK(Store::open(on.sharded(), {}, default_backends()).sequence() == 2);
    const Error moved = part_error(stale, 0);
    CHECK(moved.code() == ErrorCode::kBadState);
    CHECK_THAT(moved.what(), Catch::Contains("expected version 1"));
    pass_in_parts(on, kSmooth);
    for (const fs::path& old : {plan, same, stale})
      CHECK(error_of([&] { join(old, on.sharded()); }).code() == ErrorCode::kBadState);
    // The store that the plan names was replaced.
    const fs::path late = on.plan(kSmooth, "late");
    fs::remove_all(on.sharded());
    fs::rename(other.sharded(), on.sharded());
    const Error replaced = part_error(late, 0);
    CHECK(replaced.code() == ErrorCode::kBadState);
    CHECK_THAT(replaced.what(), Catch::Contains("another one"));
  }
  SECTION("options that a pass does not have") {
    JoinOptions concat, replace;
    concat.concat = true;
    replace.existing = Existing::kReplace;
    for (const JoinOptions& options : {concat, replace})
      CHECK(error_of([&] { join(plan, on.sharded(), options); }).code() ==
            ErrorCode::kInvalidArgument);
  }
}

TEST_CASE("PassJoin_AfterOneThatWasKilled_ReplacesWhatThatLeft") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const std::string before = digest_of(on.sharded());
  const fs::path plan = on.plan(kSmooth);
  make_parts(plan);
  // All but the manifest may be there, whole or not.
  for (const char* const name : {"attribute1.levels.2.shard1", "version.2.shard0", "version.2",
                                 "attribute1.base.2", "version.2.shard2"})
    write_content(on.sharded() / name, "left");
  CHECK(digest_of(on.sharded()) == before);
  REQUIRE(join(plan, on.sharded()).has_store);
  CHECK(digest_of(on.sharded()) != before);
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
}

TEST_CASE("PassJoin_SameVersionOfAnotherPlan_IsNotTakenForItsOwn") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan(kSmooth), other = on.plan({.factor = 0.1}, "other");
  for (const fs::path& each : {plan, other}) make_parts(each);
  REQUIRE(join(other, on.sharded()).has_store);
  const Error error = error_of([&] { join(plan, on.sharded()); });
  CHECK(error.code() == ErrorCode::kBadState);
  CHECK_THAT(error.what(), Catch::Contains("another plan"));
}

// The number of a version says nothing of the way to it: both copies have version 2.
TEST_CASE("PassInParts_CopyThatWentItsOwnWay_IsRefusedByPartAndJoin") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path copy = here.path() / "copy", moved = here.path() / "moved";
  fs::copy(on.sharded(), copy);
  pass_in_parts(on, {.factor = 0.1});
  fs::rename(on.sharded(), moved);
  fs::rename(copy, on.sharded());
  pass_in_parts(on, {.factor = 0.5});
  const std::string before = digest_of(moved);

  const fs::path plan = on.plan(kSmooth);
  const Error part = error_of([&] { make_part(plan, 1, {.store = moved}, default_backends()); });
  CHECK(part.code() == ErrorCode::kBadState);
  CHECK_THAT(part.what(), Catch::Contains("a copy of the store that went its own way"));
  make_parts(plan);
  for (const bool verify : {false, true}) {
    const Error joined = error_of([&] { join(plan, moved, {.verify = verify}); });
    CHECK(joined.code() == ErrorCode::kBadState);
    CHECK_THAT(joined.what(), Catch::Contains("a copy of the store that went its own way"));
  }
  CHECK(digest_of(moved) == before);
  CHECK(join(plan, on.sharded()).has_store);
}

// A file system without locks stands for one whose locks another machine does not see.
TEST_CASE("OldVersions_WhereNobodyKnowsWhoReads_StayUntilTheirTime") {
  struct NoLocks final : FileOperationHook {
    NoLocks() { set_file_operation_hook(this); }
    ~NoLocks() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation& operation) noexcept override {
      if (operation.kind != FileOperation::Kind::kLock) return {};
      return {.error = ENOSYS};
    }
    void after(const FileOperation&) noexcept override {}
  };
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path old = on.sharded() / "attribute0.levels.1.shard1";
  const Directory store(on.sharded());
  {
    const NoLocks no_locks;
    const fs::path plan = on.plan(kSmooth);
    make_parts(plan);
    std::vector<std::string> warnings;
    const JoinOptions options{
        .warn = [&](const std::string& warning) { warnings.push_back(warning); }};
    REQUIRE(join(plan, on.sharded(), options).has_store);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Catch::Contains("no locks"));
    CHECK(fs::exists(old));
    const RemovedVersions kept =
        remove_versions_replaced_before(store, std::chrono::hours(1), false);
    CHECK(kept.files == 0);
    CHECK(kept.versions_kept == 1);
    const RemovedVersions listed =
        remove_versions_replaced_before(store, std::chrono::seconds(0), true);
    CHECK(listed.files > 3);
    CHECK(fs::exists(old));
    CHECK(remove_versions_replaced_before(store, std::chrono::seconds(0), false).files ==
          listed.files);
    CHECK_FALSE(fs::exists(old));
  }
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
  // A lock that is seen counts whatever the time.
  const Store reader = Store::open(on.sharded(), {}, default_backends());
  pass_in_parts(on, kSmooth);
  CHECK(remove_versions_replaced_before(store, std::chrono::seconds(0), false).versions_kept == 1);
  CHECK(fs::exists(on.sharded() / "attribute1.levels.2.shard1"));
}

TEST_CASE("PlanAgain_AfterPasses_MendsWhatTheSubdivisionMade") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  pass_in_parts(on, {.name = "normals"});
  const std::string before = digest_of(on.sharded());
  const fs::path plan = here.path() / "again", level = on.sharded() / "attribute0.levels.1.shard1";
  damage_own(level, 3);
  plan_again(on.sharded(), plan, default_backends());
  make_part(plan, 1, {}, default_backends());
  CHECK(join(plan, on.sharded()).was_joined);
  CHECK(digest_of(on.sharded()) == before);
  CHECK(Store::open(on.sharded(), {}, default_backends()).sequence() == 2);
  fs::remove_all(plan);
  // The positions of a pass are those of no subdivision.
  pass_in_parts(on, kSmooth);
  const Error smoothed = error_of([&] { plan_again(on.sharded(), plan, default_backends()); });
  CHECK(smoothed.code() == ErrorCode::kNotSupported);
  on.make_whole();
  const Error whole = error_of([&] { plan_again(on.whole(), plan, default_backends()); });
  CHECK(whole.code() == ErrorCode::kNotSupported);
  CHECK_FALSE(fs::exists(plan));
}

TEST_CASE("PassPart_StoreAtAnotherPath_IsReadThere") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan(kSmooth), moved = here.path() / "moved.plait";
  fs::copy(on.sharded(), moved);
  make_part(plan, 0, {}, default_backends());
  fs::remove_all(on.sharded());
  const Error away = part_error(plan, 1);
  CHECK(away.code() == ErrorCode::kNotFound);
  CHECK_THAT(away.what(), Catch::Contains("no such store") && Catch::Contains("--store"));
  const PartOptions there{.store = moved};
  for (const std::uint32_t part : {1u, 2u}) make_part(plan, part, there, default_backends());
  CHECK(join(plan, moved).has_store);
  // A part of a subdivision reads no store.
  const Error none = error_of([&] { make_part(on.plan_shards(3), 0, there, default_backends()); });
  CHECK(none.code() == ErrorCode::kInvalidArgument);
}

// Whatever a plan says, the store is what counts: no size of a plan takes memory before the store
// has confirmed it.
TEST_CASE("PassPlan_Forged_IsDamageOfThePlanOrRefusedInWords") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  on.make_shards(3);
  const fs::path plan = on.plan({.name = "noise", .amplitude = 1e-3});
  const std::string good = content_of(plan / "plan");
  make_parts(plan);
  const auto check = [&](const std::string& bytes) {
    write_content(plan / "plan", sealed(bytes));
    const auto harmless = [](const std::function<void()>& call) {
      try {
        call();
      } catch (const Error& error) {
        CAPTURE(error.what());
        CHECK(error.code() != ErrorCode::kOutOfMemory);
        CHECK(error.code() != ErrorCode::kBudget);
        CHECK_THAT(error.what(), !Catch::Contains("memory"));
      }
    };
    harmless([&] { make_part(plan, 1, {}, default_backends()); });
    harmless([&] { join(plan, on.sharded()); });
  };
  // The store goes on only by the good plan. Each eight bytes become a huge number, and each byte
  // another one.
  const std::string first = digest_of(on.sharded());
  for (std::size_t at = 0; at + 16 < good.size(); at += unless_sanitized<std::size_t>(3, 15)) {
    CAPTURE(at);
    std::string bytes = good;
    if (at % 2 == 0)
      std::memset(bytes.data() + at, 0xfe, 8);
    else
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    check(bytes);
    if (digest_of(on.sharded()) != first) FAIL("a forged plan was joined");
  }
  write_content(plan / "plan", good);
  make_parts(plan);
  CHECK(join(plan, on.sharded()).has_store);
}

}  // namespace plait::test::passes
