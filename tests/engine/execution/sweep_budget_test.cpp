// The sweep executor under the smallest budget that sweep_window_bytes() names.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>

#include "engine/execution/naive_reach.h"
#include "engine/store/sample_store.h"
#include "plait/extend/sweep.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kBudgetLevels = 3;
constexpr std::uint64_t kSmallestBudget = 64 << 10;

/// A committed store with sample positions and an attribute "sum" that was never written.
std::filesystem::path make_budget_store(const TemporaryDirectory& directory,
                                        const std::string& backend, const BaseMesh& base) {
  const std::filesystem::path path = directory.path() / "s.plait";
  Store store = Store::create(path, base, sample_options(backend), default_backends());
  add_sample(store, sample_schemas()[0], kBudgetLevels);
  const AttributeId sum = store.add_attribute(schema_of<std::uint32_t>("sum"));
  for (int level = 1; level <= kBudgetLevels; ++level) store.add_level(sum);
  store.commit();
  return path;
}

/// Reads all slots within reach, and writes sums over them to the edge's own slot.
struct SumPass {
  SumPass(const BaseMesh& base, Reach reach) : reach_of(naive_reach(base, reach)) {
    pass.name = "sums";
    pass.accesses = {{0, 1, kBudgetLevels, Access::kRead, reach},
                     {1, kBudgetLevels, kBudgetLevels, Access::kOverwrite, Reach::kOwn}};
    pass.kernel = [this, &base](const SweepView& view, EdgeId edge, int) {
      std::uint32_t sum = 0;
      for (const EdgeId other : reach_of[edge])
        for (int level = 1; level <= kBudgetLevels; ++level) {
          const std::span<std::byte> slot = view.slot(0, level, other).bytes;
          const Edge& ends = base.edges()[other];
          if (!std::ranges::equal(
                  slot, sample_slot(sample_schemas()[0], level, ends.start, ends.end, slot.size())))
            right = false;
          for (const std::byte byte : slot) sum = 31 * sum + static_cast<std::uint32_t>(byte);
        }
      for (std::uint32_t& record : view.records<std::uint32_t>(1, kBudgetLevels, edge))
        record = sum++;
      ++calls;
    };
  }
  std::vector<std::set<EdgeId>> reach_of;
  std::atomic<bool> right = true;
  std::atomic<std::uint64_t> calls = 0;
  SweepPass pass;
};

}  // namespace

TEST_CASE("Sweep_SmallestBudget_SeesEverySlotInReachWhateverTheThreads", "[threads]") {
  int tight = 0;
  for (const std::string& backend : durable_backends())
    for (std::uint64_t seed = 1; seed <= unless_sanitized(3u, 1u); ++seed)
      for (const Reach reach : unless_sanitized(
               std::vector{Reach::kOwn, Reach::kFaces, Reach::kRing}, std::vector{Reach::kRing})) {
        const BaseMesh base = BaseMesh::build(seed == 2   ? random_sheet(seed, 300)
                                              : seed == 3 ? random_torus(seed, 300)
                                                          : random_sphere(seed, 300));
        std::vector<std::byte> first_result;
        for (const int threads : {1, 2}) {
          INFO(backend << ", seed " << seed << ", reach " << static_cast<int>(reach) << ", threads "
                       << threads);
          const TemporaryDirectory directory(Medium::kMemory);
          const std::filesystem::path path = make_budget_store(directory, backend, base);
          SumPass sums(base, reach);
          std::uint64_t needed = 0;
          {
            Store store =
                Store::open(path, {.writable = true, .budget_bytes = 16 << 20}, default_backends());
            needed = sweep_window_bytes(store, sums.pass, threads);
            CHECK(needed % 4096 == 0);
          }
          const std::uint64_t budget = std::max(needed, kSmallestBudget);
          Store store =
              Store::open(path, {.writable = true, .budget_bytes = 16 << 20}, default_backends());
          leave_for_frames(store, budget);
          sweep(store, sums.pass, {threads, {}});
          CHECK(sums.right);
          CHECK(sums.calls == base.edge_count());
          if (needed >= kSmallestBudget) {
            ++tight;
            CHECK(store.info().paging.peak_frame_bytes == needed);
          }
          const std::vector<std::byte> result = read_level(store, 1, kBudgetLevels);
          if (threads == 1) first_result = result;
          CHECK(result == first_result);
        }
      }
  CHECK(tight >= unless_sanitized(36, 6));  // all of kFaces and kRing
}

TEST_CASE("Sweep_BudgetOneByteTooSmall_IsRefusedBeforeAnythingIsTouched") {
  for (const std::string& backend : durable_backends())
    for (const int threads : {1, 2}) {
      const TemporaryDirectory directory(Medium::kMemory);
      const BaseMesh base = BaseMesh::build(random_sheet(2, 300));
      const std::filesystem::path path = make_budget_store(directory, backend, base);
      SumPass sums(base, Reach::kFaces);
      std::uint64_t needed = 0;
      {
        Store store =
            Store::open(path, {.writable = true, .budget_bytes = 16 << 20}, default_backends());
        needed = sweep_window_bytes(store, sums.pass);  // of one thread
      }
      REQUIRE(needed > kSmallestBudget);
      Store store =
          Store::open(path, {.writable = true, .budget_bytes = 16 << 20}, default_backends());
      leave_for_frames(store, needed - 1);
      const Error error = error_of([&] { sweep(store, sums.pass, {threads, {}}); });
      CHECK(error.code() == ErrorCode::kBudget);
      CHECK(names(error, {"'sums'", "needs " + std::to_string(needed), "span"}));
      CHECK(sums.calls == 0);
      CHECK(store.info().paging.blocks_read == 0);
      CHECK(store.info().paging.peak_frame_bytes == 0);
    }
}

TEST_CASE("Sweep_WithMoreThreadsThanTheBudgetHolds_TakesFewer", "[threads]") {
  const TemporaryDirectory directory(Medium::kMemory);
  const BaseMesh base = BaseMesh::build(random_sheet(2, 300));
  const std::filesystem::path path = make_budget_store(directory, "pread", base);
  SumPass sums(base, Reach::kFaces);
  Store store = Store::open(path, {.writable = true, .budget_bytes = 16 << 20}, default_backends());
  const std::uint64_t one = sweep_window_bytes(store, sums.pass),
                      many = sweep_window_bytes(store, sums.pass, 200);
  REQUIRE(many > one);
  REQUIRE(one >= kSmallestBudget);
  leave_for_frames(store, many - 1);
  sweep(store, sums.pass, {200, {}});
  CHECK(sums.right);
  CHECK(sums.calls == base.edge_count());
  CHECK(store.info().paging.peak_frame_bytes < many);
}

TEST_CASE("SweepWindowBytes_WiderReachOrMoreLevels_NeedsMore") {
  const TemporaryDirectory directory(Medium::kMemory);
  const BaseMesh base = BaseMesh::build(random_sphere(1, 300));
  Store store = Store::open(make_budget_store(directory, "pread", base), {}, default_backends());
  const auto needed = [&](int first, int last, Reach reach) {
    return sweep_window_bytes(store, {.accesses = {{0, first, last, Access::kRead, reach}}});
  };
  CHECK(needed(3, 3, Reach::kOwn) == 4096);
  CHECK(needed(1, 3, Reach::kOwn) == 3 * 4096);
  CHECK(needed(3, 3, Reach::kOwn) < needed(3, 3, Reach::kFaces));
  CHECK(needed(3, 3, Reach::kFaces) < needed(3, 3, Reach::kRing));
  CHECK(needed(3, 3, Reach::kFaces) < needed(2, 3, Reach::kFaces));
  CHECK(needed(1, 0, Reach::kRing) == 0);
}
