// A subdivision as a job: planned, watched, cancelled wherever it is, resumed.
#include "plait/subdivision_job.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/own_rule.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

constexpr int kJobLevels = 4;

/// How a run meets a store of its name.
constexpr bool kNew = false, kResume = true;

SubdivisionRequest request_for(const fs::path& store, bool resume) {
  SubdivisionRequest request{.mesh = BaseMesh::build(random_sheet(5, 60)),
                             .store = store,
                             .levels = kJobLevels,
                             .normals = true,
                             .durability = Durability::kNone,
                             .resume = resume};
  request.max_slot_bytes = 100;  // refines the base mesh twice in memory
  request.block_bytes = 4 << 10;
  request.budget_bytes = 4 << 20;
  return request;
}

std::string digest_of(const fs::path& path) {
  Store store = Store::open(path, {}, default_backends());
  CHECK(verify(store).damaged.empty());
  return digest(store).to_string();
}

/// What one run gives that nobody interrupts.
std::string uninterrupted_digest(const fs::path& directory, bool resume) {
  SubdivisionRequest request = request_for(directory / "whole.plait", resume);
  request.digest = true;
  const std::string found = SubdivisionJob(request, default_backends()).run().digest;
  fs::remove_all(directory / "whole.plait");
  return found;
}

/// Runs a new job and cancels it at its `calls`-th progress; whether it was cancelled before its
/// end.
bool run_and_cancel(const SubdivisionRequest& request, int calls) {
  SubdivisionJob job(request, default_backends());
  JobWatch watch;
  watch.progress = [&](const Progress&) { return calls-- > 0; };
  try {
    job.run(watch);
    return false;
  } catch (const Error& error) {
    CAPTURE(error.what());
    REQUIRE(error.code() == ErrorCode::kCancelled);
    return true;
  }
}

std::vector<std::string> refused_fields(const SubdivisionRequest& request) {
  const SubdivisionJob job(request, default_backends());
  std::vector<std::string> fields;
  for (const SubdivisionRefusal& refusal : job.plan().refusals) fields.push_back(refusal.option);
  return fields;
}

using Fields = std::vector<std::string>;

struct ThirdsRule {
  template <class V>
  V odd(V a, V b, V c, V d) const {
    return (a + b) / 3 + (c + d) / 6;
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
  template <class V>
  V even(V v, V ring) const {
    return v / 3 + ring / 9;
  }
  template <class V>
  V even_border(V v, V p, V q) const {
    return 0.5 * v + 0.25 * (p + q);
  }
  double even_weight(int valence) const { return 2 / (3.0 * valence); }
};

}  // namespace

TEST_CASE("SubdivisionJob_Watched_TellsEveryStepInOrderAndHowFarItIs") {
  const TemporaryDirectory here;
  SubdivisionRequest request = request_for(here.path() / "s.plait", kNew);
  request.digest = true;
  std::vector<std::string> steps;
  std::map<std::string, std::uint64_t> done;
  JobWatch watch;
  bool begins = false;
  watch.step = [&](std::string_view step) {
    steps.emplace_back(step);
    begins = true;
  };
  watch.progress = [&](const Progress& now) {
    REQUIRE_FALSE(steps.empty());
    if (begins) CHECK(now.done == 0);
    begins = false;
    CHECK(now.done <= now.total);
    CHECK(now.done >= done[steps.back()]);
    done[steps.back()] = now.done;
    return true;
  };
  SubdivisionJob job(request, default_backends());
  const SubdivisionResult result = job.run(watch);
  CHECK(steps ==
        std::vector<std::string>{"base mesh", "layout", "levels", "commit", "digest", "publish"});
  CHECK(done["levels"] > result.plan.level_counts[kJobLevels].vertices / 2);
  CHECK(result.digest == digest_of(here.path() / "s.plait"));
  CHECK(result.store == here.path() / "s.plait");
  CHECK(result.plan.base_level == 2);
  CHECK(result.base.faces == 16 * result.plan.input.faces);
  CHECK(result.plan.level_counts[2].vertices == result.base.vertices);
  CHECK(result.paging.bytes_written == result.plan.size.level_bytes);
  CHECK(result.stored_bytes >= result.plan.size.level_bytes);
  CHECK_FALSE(result.in_memory.has_value());
  CHECK_THROWS_AS(job.run(), Error);
}

TEST_CASE("SubdivisionJob_CancelledAnywhere_LeavesNothing") {
  const TemporaryDirectory here(Medium::kMemory);
  const std::string expected = uninterrupted_digest(here.path(), kNew);
  const SubdivisionRequest request = request_for(here.path() / "s.plait", kNew);
  int calls = 0;
  while (run_and_cancel(request, calls)) {
    CAPTURE(calls);
    CHECK(fs::is_empty(here.path()));
    ++calls;
  }
  CHECK(calls >= 5);  // a step each, at least
  CHECK(digest_of(here.path() / "s.plait") == expected);
}

TEST_CASE("SubdivisionJob_CancelledAnywhereAndResumed_ArrivesAtTheSameContent") {
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    const TemporaryDirectory here(Medium::kMemory);
    SubdivisionRequest request = request_for(here.path() / "s.plait", kResume);
    request.backend = backend;
    const std::string expected = uninterrupted_digest(here.path(), kResume);
    int level = 0;
    std::set<int> committed;
    for (int calls = 0; run_and_cancel(request, calls); ++calls) {
      CAPTURE(backend, calls);
      const SubdivisionJob next(request, default_backends());
      if (!next.plan().earlier) {
        CHECK(level == 0);
        continue;
      }
      CHECK(next.plan().earlier->level >= level);
      level = next.plan().earlier->level;
      committed.insert(level);
    }
    CHECK(committed == std::set{2, 3, 4});  // the base level, and each level by itself
    CHECK(digest_of(here.path() / "s.plait") == expected);
    SubdivisionJob again(request, default_backends());
    REQUIRE(again.plan().earlier.has_value());
    CHECK(again.plan().earlier->finished);
    CHECK(again.run().resumed_level == kJobLevels);
    CHECK(digest_of(here.path() / "s.plait") == expected);
  }
}

TEST_CASE("SubdivisionJob_OneLevelMoreThanTheEarlierRun_MakesIt") {
  const TemporaryDirectory here(Medium::kMemory);
  SubdivisionRequest request = request_for(here.path() / "s.plait", kResume);
  request.max_slot_bytes.reset();
  request.normals = false;
  request.levels = kJobLevels - 1;
  SubdivisionJob(request, default_backends()).run();
  request.levels = kJobLevels;
  SubdivisionJob job(request, default_backends());
  REQUIRE(job.plan().earlier.has_value());
  CHECK_FALSE(job.plan().earlier->finished);
  job.run();
  CHECK(Store::open(request.store, {}, default_backends()).finest_level() == kJobLevels);
}

TEST_CASE("SubdivisionJob_OfAStoreThatSubdivideMade_GoesOn") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  SubdivisionRequest request = request_for(path, kResume);
  request.max_slot_bytes.reset();
  request.block_bytes.reset();
  {
    const BaseMesh mesh = std::get<BaseMesh>(request.mesh);
    Store store = Store::create(path, lay_out(mesh, LayoutKind::kSpatial), {}, default_backends());
    add_base_positions(store);
    subdivide(store, {.scheme = Scheme::kButterfly, .executor = ExecutorKind::kFused, .levels = 2});
    store.commit();
  }
  SubdivisionJob job(request, default_backends());
  REQUIRE(job.plan().earlier.has_value());
  CHECK(job.plan().earlier->level == 2);
  CHECK(job.plan().subdivide.scheme == Scheme::kButterfly);
  CHECK(job.plan().layout == LayoutKind::kSpatial);
  job.run();
  SubdivisionRequest whole = request;
  whole.store = here.path() / "whole.plait";
  whole.scheme = Scheme::kButterfly;
  whole.resume = false;
  SubdivisionJob(whole, default_backends()).run();
  CHECK(digest_of(path) == digest_of(whole.store));
}

TEST_CASE("SubdivisionJob_OfAProgramsOwnRule_IsMadeAndResumedByIt") {
  const TemporaryDirectory here;
  SubdivisionRequest request = request_for(here.path() / "s.plait", kResume);
  request.scheme = own_scheme("thirds", ThirdsRule());
  const BaseMesh mesh = std::get<BaseMesh>(request.mesh);

  // Without a job: the same base mesh, refined by the same rule.
  const int base_level = rebase_levels(kJobLevels, 12, *request.max_slot_bytes);
  Store expected =
      Store::create({}, rebase(mesh, base_level, *request.scheme), {.backend = "memory"},
                    default_backends(), {.base_level = base_level});
  add_base_positions(expected);
  subdivide(expected, {.scheme = *request.scheme, .levels = kJobLevels, .normals = true});

  request.levels = kJobLevels - 1;
  request.normals = false;
  {
    // One level less has a base mesh that is one level coarser, unless slots may be smaller.
    SubdivisionRequest first = request;
    first.max_slot_bytes = 40;
    const SubdivisionResult result = SubdivisionJob(first, default_backends()).run();
    CHECK(result.plan.base_level == base_level);
    CHECK(result.plan.subdivide.scheme == *request.scheme);
  }
  request.levels = kJobLevels;
  request.normals = true;
  SubdivisionRequest without = request;
  without.scheme.reset();
  CHECK(refused_fields(without) == Fields{"scheme"});
  SubdivisionRequest other = request;
  other.scheme = own_scheme("other", ThirdsRule());
  CHECK(refused_fields(other) == Fields{"scheme"});
  SubdivisionJob(request, default_backends()).run();
  Store found = Store::open(request.store, {}, default_backends());
  CHECK(found.provenance().scheme == "thirds");
  CHECK(digest(found) == digest(expected));
}

TEST_CASE("SubdivisionPlan_OfWhatCannotBe_NamesTheMembersThatWouldHaveToChange") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  SubdivisionRequest request = request_for(path, kNew);
  request.pipeline_of = [](const AttributeSchema&) { return "lz4"; };
  request.backend = "pread";
  CHECK(refused_fields(request) == Fields{"backend"});
  request.backend.reset();
  CHECK(SubdivisionJob(request, default_backends()).plan().store.backend == "compressed");
  request.backend = "compressed";
  CHECK(refused_fields(request).empty());
  SubdivisionJob(request, default_backends()).run();
  CHECK(refused_fields(request) == Fields{"force"});
  request.existing = Existing::kReplace;
  CHECK(refused_fields(request).empty());

  request.resume = true;
  CHECK(refused_fields(request) == Fields{""});
  request.existing = Existing::kRefuse;
  request.limit = true;
  request.executor = ExecutorKind::kFused;
  CHECK(refused_fields(request) == Fields{"executor", "limit"});
  request.limit = false;
  request.executor = ExecutorKind::kAuto;
  CHECK(refused_fields(request).empty());
  request.pipeline_of = [](const AttributeSchema&) { return "zstd:3"; };
  request.block_bytes = 8 << 10;
  request.scheme = Scheme::kMidpoint;
  request.precision = ComponentType::kFloat64;
  request.levels = kJobLevels - 1;
  request.max_slot_bytes.reset();
  CHECK(refused_fields(request) == Fields{"compress", "block", "scheme", "precision", "levels"});

  request = request_for(path, kResume);
  request.max_errors.add("1e-3");
  CHECK(refused_fields(request) == Fields{"max-error"});
  request.resume = false;
  request.existing = Existing::kReplace;
  CHECK(refused_fields(request).empty());
  request.max_errors.add("limit=1e-3");
  CHECK(refused_fields(request) == Fields{"max-error"});

  request = request_for(path, kResume);
  request.levels = 15;
  request.max_slot_bytes.reset();
  request.block_bytes.reset();
  request.store = here.path() / "large.plait";
  CHECK(refused_fields(request) == Fields{"ignore-size"});
  request.ignore_size = true;
  CHECK(refused_fields(request).empty());
  CHECK_FALSE(fs::exists(request.store));
  request.ignore_size = false;
  request.resume = false;
  request.store.clear();
  request.backend = "memory";
  const SubdivisionJob in_memory(request, default_backends());
  REQUIRE(in_memory.plan().refusals.size() == 1);
  CHECK(in_memory.plan().refusals[0].code == ErrorCode::kOutOfMemory);
}

TEST_CASE("SubdivisionPlan_SizeOfAResumedRun_IsThatOfTheRemainingWork") {
  const TemporaryDirectory here(Medium::kMemory);
  SubdivisionRequest request = request_for(here.path() / "s.plait", kResume);
  request.max_slot_bytes.reset();
  request.normals = false;
  request.executor = ExecutorKind::kSweep;
  request.levels = kJobLevels - 1;
  const auto vertices = [&](int level) {
    return counts_at_level(std::get<BaseMesh>(request.mesh), level).vertices;
  };
  const auto disk_bytes = [&] {
    return SubdivisionJob(request, default_backends()).plan().size.disk_bytes;
  };
  const std::uint64_t point = 3 * sizeof(float);
  const int done = request.levels;
  SubdivisionJob(request, default_backends()).run();
  // Only normals are missing.
  request.normals = true;
  CHECK(disk_bytes() == point * (vertices(done) - vertices(0)));
  // One more level: Loop writes the coarser ones anew, beside those of the last commit.
  request.levels = done + 1;
  CHECK(disk_bytes() ==
        point * ((vertices(done + 1) - vertices(done)) + (vertices(done + 1) - vertices(0)) +
                 (vertices(done) - vertices(0))));
  request.normals = false;
  CHECK(disk_bytes() ==
        point * ((vertices(done + 1) - vertices(done)) + (vertices(done) - vertices(0))));
  // With normals of the earlier run, these are made anew with the level, and not without.
  request.levels = done;
  request.normals = true;
  SubdivisionJob(request, default_backends()).run();
  CHECK(disk_bytes() == 0);
  request.levels = done + 1;
  CHECK(disk_bytes() ==
        point * ((vertices(done + 1) - vertices(done)) + (vertices(done + 1) - vertices(0)) +
                 (vertices(done) - vertices(0))));
  // A scheme that moves no coarser vertices writes the new level only.
  request.store = here.path() / "midpoint.plait";
  request.scheme = Scheme::kMidpoint;
  request.normals = false;
  request.levels = done;
  SubdivisionJob(request, default_backends()).run();
  request.levels = done + 1;
  CHECK(disk_bytes() == point * (vertices(done + 1) - vertices(done)));
}

TEST_CASE("SubdivisionPlan_MemoryOfABackendThatKeepsNothing_HasAllLevelsAndRoundedCopies") {
  SubdivisionRequest request = request_for("", kNew);
  request.backend = "memory";
  request.budget_bytes = 64 << 10;
  request.max_slot_bytes.reset();
  const auto size = [&] { return SubdivisionJob(request, default_backends()).plan().size; };
  const SubdivisionSize exact = size();
  const std::uint64_t born =
      counts_at_level(std::get<BaseMesh>(request.mesh), kJobLevels).vertices -
      std::get<BaseMesh>(request.mesh).vertex_count();
  CHECK(exact.level_bytes == born * 24);
  CHECK(exact.rounded_bytes == 0);
  CHECK(exact.memory_bytes == exact.base_mesh_bytes + exact.level_bytes);
  CHECK(exact.disk_bytes == 0);
  request.max_errors.add("1e-3");
  request.max_errors.add("normal=1e-3");
  const SubdivisionSize rounded = size();
  CHECK(rounded.rounded_bytes == born * 24);
  CHECK(rounded.memory_bytes == rounded.base_mesh_bytes + 2 * rounded.level_bytes);
}

TEST_CASE("SubdivisionPlan_LimitOfASchemeWithoutLimitPositions_IsRefusedBeforeTheMeshIsRead") {
  const TemporaryDirectory here;
  SubdivisionRequest request = request_for(here.path() / "s.plait", kNew);
  request.mesh = here.path() / "missing.ply";
  request.limit = true;
  for (const SchemeTraits& scheme : schemes()) {
    request.scheme = scheme_from_name(scheme.name);
    CAPTURE(scheme.name);
    if (scheme.has_limits) {
      CHECK_THROWS_AS(SubdivisionJob(request, default_backends()), Error);
      continue;
    }
    SubdivisionJob job(request, default_backends());
    REQUIRE(job.plan().refusals.size() == 1);
    CHECK(job.plan().refusals[0].option == "limit");
    CHECK(job.plan().refusals[0].code == ErrorCode::kNotSupported);
    CHECK_THAT(job.plan().refusals[0].reason, Catch::Contains("has no limit positions"));
    CHECK_THROWS_AS(job.run(), Error);
    CHECK(fs::is_empty(here.path()));
  }
}

TEST_CASE("SubdivisionJob_OfAnotherMeshThanTheEarlierRun_IsRefusedInWords") {
  const TemporaryDirectory here;
  SubdivisionRequest request = request_for(here.path() / "s.plait", kResume);
  SubdivisionJob(request, default_backends()).run();
  request.mesh = BaseMesh::build(random_sheet(6, 60));
  SubdivisionJob job(request, default_backends());
  CHECK(job.plan().refusals.empty());
  CHECK_THROWS_AS(job.run(), Error);
  REQUIRE(job.plan().refusals.size() == 1);
  CHECK(job.plan().refusals[0].option == "input");
}

TEST_CASE("SubdivisionJob_OfABackendThatKeepsNothing_HandsTheStoreOver") {
  SubdivisionRequest request = request_for({}, kNew);
  request.backend = "memory";
  request.digest = true;
  SubdivisionResult result = SubdivisionJob(request, default_backends()).run();
  CHECK(result.store.empty());
  REQUIRE(result.in_memory.has_value());
  CHECK(digest(*result.in_memory).to_string() == result.digest);
}

TEST_CASE("SubdivisionPlan_WithoutABackend_AsksTheChooserForTheSizeOfTheLevels") {
  const TemporaryDirectory here;
  SubdivisionRequest request = request_for(here.path() / "s.plait", kNew);
  std::uint64_t asked_bytes = 0;
  BackendRegistry backends = default_backends();
  backends.set_chooser([&](const BackendRegistry&, const NewStore& store) -> BackendChoice {
    CHECK(store.path == request.store);
    asked_bytes = store.level_bytes;
    return {"compressed", "the test says so"};
  });
  const SubdivisionJob job(request, backends);
  CHECK(job.plan().store.backend == "compressed");
  CHECK(job.plan().backend_reason == "the test says so");
  const std::vector<LevelCounts>& counts = job.plan().level_counts;
  CHECK(asked_bytes == 24 * (counts[kJobLevels].vertices - counts[2].vertices));
  CHECK(job.plan().size.level_bytes == asked_bytes);
}

TEST_CASE("SubdivisionJob_OnThePoolOfTheProgram_GivesTheSameBits") {
  const BaseMesh base = BaseMesh::build(random_sphere(8, 200));
  const auto run = [&](const ParallelFor& loop) {
    SubdivisionRequest request{.mesh = base, .levels = 4, .backend = "memory"};
    request.threads = 3;
    request.digest = true;
    request.parallel_for = loop;
    const BackendRegistry backends = default_backends();
    return SubdivisionJob(request, backends).run().digest;
  };
  int loops = 0;
  const std::string found = run([&](int count, const std::function<void(int)>& body) {
    ++loops;
    for (int number = count; number-- > 0;) body(number);
  });
  CHECK(loops > 1);
  CHECK(found == run({}));
}

}  // namespace plait::test
