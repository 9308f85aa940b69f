// A subdivision is told its smallest budget before it begins: with that it ends, with less it would
// not.
#include <catch2/catch.hpp>

#include "plait/error.h"
#include "run_variant.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kSmallestBudget = 64 << 10;

std::uint64_t needed_bytes(const BaseMesh& base, const SubdivideOptions& what,
                           const Variant& variant) {
  Store store = Store::create({}, base, {.backend = "memory", .block_bytes = variant.block_bytes},
                              default_backends());
  add_base_positions(store,
                     variant.double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
  return plan_subdivision(store, what).needs().frames;
}

bool fails_for_its_budget(const BaseMesh& base, const SubdivideOptions& what,
                          const Variant& variant) {
  try {
    run(base, what, variant);
  } catch (const Error& error) {
    return error.code() == ErrorCode::kBudget;
  }
  return false;
}

}  // namespace

TEST_CASE("SubdivisionNeeds_AsBudget_AreEnoughAndLessIsNot") {
  int tight = 0;
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint})
      for (const bool surface : {false, true}) {
        const BaseMesh base = BaseMesh::build(random_sheet(5, unless_sanitized(300u, 100u)));
        const SubdivideOptions what{.scheme = scheme,
                                    .executor = executor,
                                    .levels = 5,
                                    .normals = surface,
                                    .limit = surface && scheme == Scheme::kLoop};
        Variant variant;
        variant.backend = "pread";
        variant.executor = executor;
        variant.block_bytes = 4096;
        variant.double_precision = surface;
        const std::uint64_t needed = needed_bytes(base, what, variant);
        CAPTURE(to_string(executor), to_string(scheme), surface, needed);
        variant.budget_bytes = std::max(needed, kSmallestBudget);
        CHECK_NOTHROW(run(base, what, variant));
        // Patches have windows besides, which shrink with the budget: no figure is the smallest.
        if (needed <= kSmallestBudget || executor == ExecutorKind::kTransparent) continue;
        ++tight;
        variant.budget_bytes = needed - 4096;
        CHECK(fails_for_its_budget(base, what, variant));
      }
  CHECK(tight > 0);
}

TEST_CASE("Subdivide_NormalsThatAreThere_AreMadeAnewInOneCommit") {
  const BaseMesh base = BaseMesh::build(random_sheet(3, 60));
  SubdivideOptions what{.levels = 4, .normals = true};
  const std::string expected = run(base, what, {}).digest;
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const std::string backend : {"pread", "compressed"}) {
      const TemporaryDirectory directory(Medium::kMemory);
      const std::filesystem::path path = directory.path() / "s.plait";
      what.executor = executor;
      {
        Store store = Store::create(path, base, {.backend = backend}, default_backends());
        add_base_positions(store);
        what.levels = 2;
        subdivide(store, what);
        store.commit();
        what.normals = false;
        what.levels = 4;
        CHECK_THROWS_AS(subdivide(store, what), Error);
        what.normals = true;
        subdivide(store, what);
        CHECK(store.attributes().size() == 2);
        store.commit();
      }
      Store store = Store::open(path, {}, default_backends());
      CAPTURE(to_string(executor), backend);
      CHECK(store.attributes()[store.attribute("normal")].finest_level == 4);
      CHECK(digest(store).to_string() == expected);
    }
}

}  // namespace plait::test
