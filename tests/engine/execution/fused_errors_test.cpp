// How a fused pass ends when it cannot go on: with the error of whoever failed, in any thread, and
// with a store that can still be used or says that it cannot.
#include <fmt/format.h>

#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "engine/execution/numbering_refiner.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "support/counting_backend.h"
#include "support/error_of.h"
#include "support/forwarding_backend.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kErrorLevels = 7;  ///< runs of 16 faces
const std::vector<AttributeSchema> kSchemas = {{"mass", ComponentType::kFloat32, 1}};

/// In an order that keeps few blocks open, so that the others are written on the way.
BaseMesh mesh_of_failing_runs() {
  return lay_out(BaseMesh::build(random_sphere(8, unless_sanitized(200u, 66u))),
                 LayoutKind::kHilbert)
      .mesh;
}

Store store_in_memory(const BaseMesh& base) {
  StoreOptions options = sample_options("memory");
  options.budget_bytes = 256 << 20;
  return numbered_store({}, base, options, kSchemas, kErrorLevels, default_backends());
}

std::uint64_t bytes_of_levels(const Store& store) {
  std::uint64_t bytes = 0;
  for (int level = 1; level <= kErrorLevels; ++level)
    bytes += StoreAccess::level_file(store, 0, level).geometry.total_bytes();
  return bytes;
}

/// Does what a test says before each step of another refiner.
class HookedRefiner final : public PatchRefiner {
 public:
  using Hook = std::function<void(const char* step)>;
  HookedRefiner(std::unique_ptr<PatchRefiner> inner, const Hook& hook)
      : inner_(std::move(inner)), hook_(hook) {}
  void begin(std::span<const FaceId> faces) override {
    hook_("begin");
    inner_->begin(faces);
  }
  void refine(std::size_t first, std::size_t count) override {
    hook_("refine");
    inner_->refine(first, count);
  }
  const void* points(std::size_t output) const override {
    hook_("points");
    return inner_->points(output);
  }

 private:
  std::unique_ptr<PatchRefiner> inner_;
  const Hook& hook_;
};

/// `hook` outlives the pass.
FusedPass hooked(FusedPass pass, const HookedRefiner::Hook& hook) {
  pass.make_refiner = [make = pass.make_refiner, &hook]() -> std::unique_ptr<PatchRefiner> {
    hook("make");
    return std::make_unique<HookedRefiner>(make(), hook);
  };
  return pass;
}

/// The error of a pass that is cancelled when it first asks. Only the calling thread asks, so the
/// others wait until it has: they could otherwise refine all faces before it begins.
Error cancelled(Store& store, FusedPass pass, int threads) {
  std::atomic<bool> asked = false;
  const HookedRefiner::Hook hook = [&, caller = std::this_thread::get_id()](const char*) {
    if (std::this_thread::get_id() != caller) asked.wait(false);
  };
  return error_of([&] {
    fused(store, hooked(std::move(pass), hook), {threads, [&](const Progress&) {
                                                   asked = true;
                                                   asked.notify_all();
                                                   return false;
                                                 }});
  });
}

/// Refuses the `refused`-th write of all levels together.
class FullBackend final : public ForwardingBackend {
 public:
  FullBackend(std::unique_ptr<Backend> full, std::atomic<int>& writes_left)
      : ForwardingBackend(std::move(full)), writes_left_(writes_left) {}
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (--writes_left_ == 0) throw Error(ErrorCode::kNoSpace, "no room for this block");
    inner().write(blocks, from);
  }

 private:
  std::atomic<int>& writes_left_;
};

}  // namespace

TEST_CASE("Fused_Proceed_SeesFacesGrowToAllOnTheCallingThread", "[threads]") {
  const BaseMesh base = mesh_of_failing_runs();
  Store store = store_in_memory(base);
  NumberingCalls calls(base.face_count());
  FusedOptions options;
  std::vector<std::uint64_t> seen;
  bool calling_thread = true;
  options.progress = [&, caller = std::this_thread::get_id()](const Progress& now) {
    calling_thread &= std::this_thread::get_id() == caller && now.total == base.face_count();
    seen.push_back(now.done);
    return true;
  };
  fused(store, numbering_pass(store, kErrorLevels, calls), options);
  CHECK(calling_thread);
  REQUIRE(seen.size() > 3);
  CHECK(std::ranges::is_sorted(seen));
  CHECK(seen.back() == base.face_count());
}

TEST_CASE("Fused_Cancelled_LeavesAStoreThatCanBeRefinedAgain", "[threads]") {
  const BaseMesh base = mesh_of_failing_runs();
  for (const int threads : {1, 2, 4}) {
    INFO(threads << " threads");
    Store store = store_in_memory(base);
    NumberingCalls calls(base.face_count());
    const Error error = cancelled(store, numbering_pass(store, kErrorLevels, calls), threads);
    CHECK(error.code() == ErrorCode::kCancelled);
    CHECK(names(error, {"'numbering'"}));
    if (threads == 1)
      CHECK_FALSE(std::ranges::all_of(calls.refined, [](const auto& times) { return times == 1; }));
    NumberingCalls again(base.face_count());
    fused(store, numbering_pass(store, kErrorLevels, again), {threads, {}});
    CHECK(holds_numbers(store, kErrorLevels));
  }
}

TEST_CASE("Fused_CancelledOnDisk_StoreIsDestroyedAndGone", "[threads]") {
  const BaseMesh base = mesh_of_failing_runs();
  for (const std::string& backend : durable_backends()) {
    INFO(backend);
    const TemporaryDirectory directory(Medium::kMemory);
    const std::filesystem::path path = directory.path() / "s.plait";
    {
      StoreOptions options = sample_options(backend);
      options.budget_bytes = 64 << 20;
      Store store = numbered_store(path, base, options, kSchemas, kErrorLevels, default_backends());
      NumberingCalls calls(base.face_count());
      const Error error = cancelled(store, numbering_pass(store, kErrorLevels, calls), 2);
      CHECK(error.code() == ErrorCode::kCancelled);
    }
    CHECK_FALSE(std::filesystem::exists(path));
  }
}

TEST_CASE("Fused_RefinerThrowsInAnyStepOfAnyThread_ComesOut", "[threads]") {
  const BaseMesh base = mesh_of_failing_runs();
  for (const std::string failing : {"make", "begin", "refine", "points"})
    for (const bool in_helper : {false, true}) {
      INFO(failing << (in_helper ? " of a helper" : " of the caller"));
      Store store = store_in_memory(base);
      NumberingCalls calls(base.face_count());
      std::atomic<bool> thrown = false;
      const HookedRefiner::Hook hook = [&, caller = std::this_thread::get_id()](const char* step) {
        const bool helper = std::this_thread::get_id() != caller;
        if (helper == in_helper && step == failing) {
          thrown = true;
          thrown.notify_all();
          throw std::out_of_range("a rule of one's own");
        }
        // The others wait, so that the one that fails has something to do.
        if (helper != in_helper) thrown.wait(false);
      };
      CHECK_THROWS_WITH(
          fused(store, hooked(numbering_pass(store, kErrorLevels, calls), hook), {4, {}}),
          "a rule of one's own");
      NumberingCalls again(base.face_count());
      fused(store, numbering_pass(store, kErrorLevels, again), {2, {}});
      CHECK(holds_numbers(store, kErrorLevels));
    }
}

TEST_CASE("Fused_WriteFails_ComesOutAsTheBackendsErrorFromAnyThread", "[threads]") {
  const BaseMesh base = mesh_of_failing_runs();
  for (const std::string backend : {"pread", "compressed"})
    for (const int threads : {1, 2, 4})
      for (const unsigned refused : {1u, 2u, 30u}) {
        INFO(backend << ", write " << refused << ", threads " << threads);
        const TemporaryDirectory directory(Medium::kMemory);
        std::atomic<int> writes_left = static_cast<int>(refused);
        const BackendRegistry backends =
            wrapped_registry(default_backends(), [&](std::unique_ptr<Backend> inner) {
              return std::make_unique<FullBackend>(std::move(inner), writes_left);
            });
        StoreOptions options = sample_options(backend);
        options.budget_bytes = 64 << 20;
        NumberingCalls calls(base.face_count());
        Store store = numbered_store(directory.path() / "s.plait", base, options, kSchemas,
                                     kErrorLevels, backends);
        const FusedPass pass = numbering_pass(store, kErrorLevels, calls);
        const std::uint64_t frames = fused_needs(store, pass, threads).frames;
        leave_for_frames(store, frames);
        const std::uint64_t block_bytes = store.options().block_bytes;
        // Nothing forces a write before the pass ends if its blocks fit into the budget together.
        const bool fails_in_pass = bytes_of_levels(store) > frames + refused * block_bytes;
        const Error error = error_of([&] {
          fused(store, pass, {threads, {}});
          REQUIRE_FALSE(fails_in_pass);
          store.commit();
        });
        CHECK(error.code() == ErrorCode::kNoSpace);
        CHECK(names(error, {"no room for this block"}));
        CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
      }
}

TEST_CASE("Fused_WrongArguments_AreRefusedBeforeAnyRefinerIsMade", "[threads]") {
  const BaseMesh base = BaseMesh::build(octahedron());
  Store store =
      numbered_store({}, base, sample_options("memory"),
                     {kSchemas[0], {"flag", ComponentType::kInt8, 3}}, 2, default_backends());
  NumberingCalls calls(base.face_count());
  FusedPass right = numbering_pass(store, 2, calls);
  right.outputs = {0};
  const auto refusal = [&](FusedPass pass, int threads) {
    const Error error = error_of([&] { fused(store, pass, {threads, {}}); });
    CHECK(names(error, {"'numbering'"}));
    CHECK(calls.refiners == 0);
    return error.code();
  };
  for (const int threads : {-1, 1025})
    CHECK(refusal(right, threads) == ErrorCode::kInvalidArgument);
  FusedPass wrong = right;
  wrong.outputs = {0, 2};
  CHECK(refusal(wrong, 1) == ErrorCode::kInvalidArgument);
  wrong.outputs = {};
  CHECK(refusal(wrong, 1) == ErrorCode::kInvalidArgument);
  wrong.outputs = {0, 1};
  CHECK(refusal(wrong, 1) == ErrorCode::kNotSupported);
  wrong.outputs = {0, 0};
  CHECK(refusal(wrong, 1) == ErrorCode::kInvalidArgument);
  wrong = right;
  wrong.finest_level = kMostFusedLevels + 1;
  CHECK(refusal(wrong, 1) == ErrorCode::kNotSupported);
  for (const int levels : {-1, 0, 3}) {
    wrong = right;
    wrong.finest_level = levels;
    wrong.lattice.size = levels == 3 ? 8 : 1;
    CHECK(refusal(wrong, 1) == ErrorCode::kInvalidArgument);
  }
  for (const PatchLattice lattice : {PatchLattice{2, 1}, PatchLattice{8, 1}, PatchLattice{4, -1}}) {
    wrong = right;
    wrong.lattice = lattice;
    CHECK(refusal(wrong, 1) == ErrorCode::kInvalidArgument);
  }
}

TEST_CASE("Fused_StoreOpenedForReading_IsRefused", "[threads]") {
  const BaseMesh base = BaseMesh::build(octahedron());
  for (const std::string& backend : durable_backends()) {
    INFO(backend);
    const TemporaryDirectory directory(Medium::kMemory);
    const std::filesystem::path path = directory.path() / "s.plait";
    {
      Store store =
          numbered_store(path, base, sample_options(backend), kSchemas, 2, default_backends());
      store.commit();
      store.close();
    }
    Store store = Store::open(path, {}, default_backends());
    NumberingCalls calls(base.face_count());
    const Error error = error_of([&] { fused(store, numbering_pass(store, 2, calls), {}); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {"'numbering'", path.native()}));
    CHECK(calls.refiners == 0);
  }
}
