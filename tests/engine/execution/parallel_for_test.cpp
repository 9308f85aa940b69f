// Executors on threads of the program: the same bits whatever its pool does, errors and cancels
// come back, and a loop that leaves bodies out is noticed.
#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "engine/execution/numbering_refiner.h"
#include "plait/digest.h"
#include "plait/extend/sweep.h"
#include "plait/layout.h"
#include "plait/progress.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/parallel_loops.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kBodies = 5;
constexpr int kPoolLevels = 7;  ///< runs of 16 faces
const std::vector<AttributeSchema> kPoolSchemas = {{"mass", ComponentType::kFloat32, 1}};

BaseMesh mesh_for_pools() {
  return lay_out(BaseMesh::build(random_sphere(8, unless_sanitized(200u, 40u))),
                 LayoutKind::kHilbert)
      .mesh;
}

Store store_for_pool(const BaseMesh& base, const ParallelFor& loop,
                     const std::filesystem::path& path = {}) {
  StoreOptions options = sample_options(path.empty() ? "memory" : "pread");
  options.budget_bytes = 64 << 20;
  options.parallel_for = loop;
  return numbered_store(path, base, options, kPoolSchemas, kPoolLevels, default_backends());
}

SweepPass pass_over_edges(const Store& store, std::function<void(EdgeId, int)> kernel) {
  SweepPass pass;
  pass.name = "edges";
  pass.accesses = {{0, 1, store.finest_level(), Access::kRead, Reach::kOwn}};
  pass.kernel = [kernel = std::move(kernel)](const SweepView&, EdgeId edge, int worker) {
    kernel(edge, worker);
  };
  return pass;
}

}  // namespace

TEST_CASE("Fused_OnThePoolOfTheProgram_MakesTheSameRecords") {
  const BaseMesh base = mesh_for_pools();
  for (const NamedLoop& pool : parallel_loops())
    for (const bool on_disk : unless_sanitized(std::vector{false, true}, std::vector{true})) {
      INFO(pool.name << (on_disk ? ", on disk" : ""));
      const TemporaryDirectory directory(Medium::kMemory);
      int loops = 0;
      Store store = store_for_pool(
          base,
          [&](int count, const std::function<void(int)>& body) {
            CHECK(count == kBodies);
            ++loops;
            pool.loop(count, body);
          },
          on_disk ? directory.path() / "s.plait" : "");
      NumberingCalls calls(base.face_count());
      fused(store, numbering_pass(store, kPoolLevels, calls), {kBodies, {}});
      CHECK(loops == 1);
      CHECK(std::ranges::all_of(calls.refined, [](const auto& times) { return times == 1; }));
      CHECK(holds_numbers(store, kPoolLevels));
    }
}

TEST_CASE("Sweep_OnThePoolOfTheProgram_CallsTheKernelOncePerEdgeThere") {
  const BaseMesh base = BaseMesh::build(torus_grid(40, 50));
  for (const NamedLoop& pool : parallel_loops()) {
    INFO(pool.name);
    StoreOptions options = sample_options("memory");
    options.parallel_for = pool.loop;
    Store store = Store::create({}, base, options, default_backends());
    add_sample(store, sample_schemas()[0], 2);
    std::vector<std::atomic<int>> calls(base.edge_count());
    std::atomic<bool> right_worker = true, by_caller = false;
    const auto caller = std::this_thread::get_id();
    sweep(store,
          pass_over_edges(store,
                          [&](EdgeId edge, int worker) {
                            ++calls[edge];
                            if (worker < 0 || worker >= kBodies) right_worker = false;
                            if (std::this_thread::get_id() == caller) by_caller = true;
                          }),
          {kBodies, {}});
    CHECK(std::ranges::all_of(calls, [](const auto& count) { return count == 1; }));
    CHECK(right_worker);
    if (!pool.by_caller) CHECK_FALSE(by_caller);
    const std::string found = digest(store, {.threads = kBodies}).to_string();
    CHECK(found == digest(store).to_string());
  }
}

TEST_CASE("Fused_RefinerThrowsOnThePoolOfTheProgram_ComesOut") {
  const BaseMesh base = mesh_for_pools();
  for (const NamedLoop& pool : parallel_loops()) {
    INFO(pool.name);
    Store store = store_for_pool(base, pool.loop);
    NumberingCalls calls(base.face_count());
    FusedPass pass = numbering_pass(store, kPoolLevels, calls);
    pass.make_refiner = []() -> std::unique_ptr<PatchRefiner> {
      throw std::out_of_range("no refiner");
    };
    CHECK_THROWS_WITH(fused(store, pass, {kBodies, {}}), "no refiner");
    fused(store, numbering_pass(store, kPoolLevels, calls), {kBodies, {}});
    CHECK(holds_numbers(store, kPoolLevels));
  }
}

TEST_CASE("Fused_OnThePoolOfTheProgram_AsksForCancelByOneThreadAtATimeAndEnds") {
  const BaseMesh base = mesh_for_pools();
  for (const NamedLoop& pool : parallel_loops()) {
    INFO(pool.name);
    Store store = store_for_pool(base, pool.loop);
    // A thread that finishes a run while another one asks does not ask. So how often a pass asks
    // depends on the scheduler, but the first run that is finished always asks.
    for (const bool go_on : {true, false}) {
      std::atomic<int> asking = 0, asked = 0;
      std::atomic<bool> alone = true;
      const FusedOptions options{kBodies, [&](const Progress& now) {
                                   if (++asking != 1 || now.total != base.face_count())
                                     alone = false;
                                   ++asked;
                                   std::this_thread::yield();
                                   --asking;
                                   return go_on;
                                 }};
      NumberingCalls calls(base.face_count());
      const FusedPass pass = numbering_pass(store, kPoolLevels, calls);
      if (go_on)
        fused(store, pass, options);
      else
        CHECK(error_of([&] { fused(store, pass, options); }).code() == ErrorCode::kCancelled);
      CHECK(alone);
      CHECK(asked >= 1);
    }
    NumberingCalls again(base.face_count());
    fused(store, numbering_pass(store, kPoolLevels, again), {kBodies, {}});
    CHECK(holds_numbers(store, kPoolLevels));
  }
}

TEST_CASE("Sweep_KernelThrowsOrIsCancelledOnThePoolOfTheProgram_ComesOut") {
  const BaseMesh base = BaseMesh::build(torus_grid(40, 50));
  for (const NamedLoop& pool : parallel_loops()) {
    INFO(pool.name);
    StoreOptions options = sample_options("memory");
    options.parallel_for = pool.loop;
    Store store = Store::create({}, base, options, default_backends());
    add_sample(store, sample_schemas()[0], 2);
    CHECK_THROWS_WITH(sweep(store,
                            pass_over_edges(store,
                                            [&](EdgeId edge, int) {
                                              if (edge == 77) throw std::out_of_range("edge 77");
                                            }),
                            {kBodies, {}}),
                      "edge 77");
    const auto caller = std::this_thread::get_id();
    bool asked_by_caller = true;
    const Error error = error_of([&] {
      sweep(store, pass_over_edges(store, [](EdgeId, int) {}),
            {kBodies, [&](const Progress&) {
               asked_by_caller = asked_by_caller && std::this_thread::get_id() == caller;
               return false;
             }});
    });
    CHECK(error.code() == ErrorCode::kCancelled);
    CHECK(asked_by_caller);
  }
}

TEST_CASE("ParallelFor_LeavesABodyOutOrCallsOneTwiceOrThrows_EndsTheCallWithAnError") {
  const BaseMesh base = mesh_for_pools();
  struct Wrong {
    ParallelFor loop;
    std::string says;
  };
  const std::vector<Wrong> wrong = {
      {[](int, const std::function<void(int)>&) {}, "ran 0 bodies, expected 5"},
      {[](int count, const std::function<void(int)>& body) {
         for (int number = 1; number < count; ++number) body(number);
       },
       "ran 4 bodies, expected 5"},
      {[](int count, const std::function<void(int)>& body) {
         for (int number = 0; number < count; ++number) body(number);
         body(0);
       },
       "called a body twice"},
      {[](int count, const std::function<void(int)>& body) {
         for (int number = 0; number <= count; ++number) body(number);
       },
       "not in [0, 5)"},
      {[](int, const std::function<void(int)>&) {
         throw Error(ErrorCode::kBadState, "the pool is shut");
       },
       "the pool is shut"}};
  for (const auto& [loop, says] : wrong) {
    Store store = store_for_pool(base, loop);
    NumberingCalls calls(base.face_count());
    const FusedPass pass = numbering_pass(store, kPoolLevels, calls);
    Error error = error_of([&] { fused(store, pass, {kBodies, {}}); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {says}));
    // The levels are unfinished; one thread needs no loop.
    CHECK(error_of([&] { digest(store, {.threads = kBodies}); }).code() == ErrorCode::kBadState);
    fused(store, pass, {1, {}});
    CHECK(holds_numbers(store, kPoolLevels));
    error = error_of([&] { digest(store, {.threads = kBodies}); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {says}));
  }
}
