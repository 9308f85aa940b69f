// subdivide() says by itself where the levels of a store come from.
#include <catch2/catch.hpp>

#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

Store new_store(const std::filesystem::path& path = {}, bool double_precision = false) {
  Store store = Store::create(path, BaseMesh::build(octahedron()), {}, default_backends(),
                              {.layout = "morton"});
  add_base_positions(store, double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
  return store;
}

}  // namespace

TEST_CASE("Subdivide_AnyExecutor_RecordsWhereLevelsComeFrom") {
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const bool double_precision : {false, true})
      for (const auto& [scheme, limit] :
           {std::pair(Scheme::kLoop, false), std::pair(Scheme::kLoop, true),
            std::pair(Scheme::kButterfly, false), std::pair(Scheme::kMidpoint, false)}) {
        Store store = new_store({}, double_precision);
        CHECK(store.provenance().scheme.empty());
        subdivide(store, {.scheme = scheme, .executor = executor, .levels = 2, .limit = limit});
        const Provenance expected{
            std::string(to_string(scheme)),
            limit,
            double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32,
            "morton",
            0,
            program_version()};
        CHECK(store.provenance() == expected);
      }
}

TEST_CASE("Subdivide_CommittedAndCopied_KeepsWhereLevelsComeFrom") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  Provenance expected;
  {
    Store store = new_store(path);
    // What is committed between two levels has no limit positions yet.
    subdivide(store, {.levels = 2, .limit = true, .level_done = [&](int) {
                        CHECK(store.provenance().scheme == "loop");
                        CHECK_FALSE(store.provenance().limit);
                        store.commit();
                      }});
    store.commit();
    expected = store.provenance();
    CHECK(expected.limit);
  }
  Store store = Store::open(path, {}, default_backends());
  CHECK(store.provenance() == expected);
  Store copy = Store::create({}, store.base(), {}, default_backends(), {.layout = "morton"});
  copy_levels(store, copy);
  CHECK(copy.provenance() == expected);
}

TEST_CASE("Subdivide_LevelsOfSeveralOrigins_AreOfUnknownProvenance") {
  Store other = new_store();
  subdivide(other, {.scheme = Scheme::kMidpoint, .levels = 1});
  subdivide(other, {.scheme = Scheme::kMidpoint, .levels = 2});
  CHECK(other.provenance().scheme == "midpoint");
  subdivide(other, {.scheme = Scheme::kLoop, .levels = 3});
  CHECK(other.provenance().scheme.empty());

  Store limit = new_store();
  subdivide(limit, {.levels = 1, .limit = true});
  subdivide(limit, {.levels = 2});
  CHECK(limit.provenance().scheme.empty());
}
