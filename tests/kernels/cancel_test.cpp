// A subdivision that was cancelled cannot be committed, wherever it was.
#include <catch2/catch.hpp>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

TEST_CASE("StoreCommit_AfterACancelledSubdivision_IsRefusedAndTheLastCommitStays") {
  for (const std::string& backend : usable_backends())
    for (const ExecutorKind executor :
         {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
      CAPTURE(backend, to_string(executor));
      // Nowhere, somewhere, ..., until nothing is left to cancel.
      bool cancelled = true;
      int refused = 0;
      for (int calls = 0; cancelled; ++calls) {
        const TemporaryDirectory directory;
        const bool in_memory = default_backends().find(backend).traits.in_memory;
        const std::filesystem::path path = in_memory ? "" : directory.path() / "s.plait";
        StoreOptions options;
        options.backend = backend;
        options.durability = Durability::kNone;
        Store store =
            Store::create(path, BaseMesh::build(icosahedron()), options, default_backends());
        add_base_positions(store);
        store.commit();
        SubdivideOptions what;
        what.levels = 3;
        what.executor = executor;
        what.normals = true;
        int left = calls;
        what.progress = [&](const Progress&) { return left-- > 0; };
        cancelled = false;
        try {
          subdivide(store, what);
        } catch (const Error& error) {
          REQUIRE(error.code() == ErrorCode::kCancelled);
          cancelled = true;
        }
        if (!cancelled) {
          CHECK_NOTHROW(store.commit());
          continue;
        }
        try {
          store.commit();
          FAIL("committed what was cancelled at call " << calls);
        } catch (const Error& error) {
          CHECK(error.code() == ErrorCode::kBadState);
          CHECK(std::string_view(error.what()).find("is unfinished") != std::string_view::npos);
          ++refused;
        }
        if (in_memory) continue;
        store.close();
        CHECK(Store::open(path, {}, default_backends()).sequence() == 1);
      }
      CHECK(refused > 0);
    }
}

TEST_CASE("StoreCommit_BetweenTheLevelsOfASubdivisionThatIsCancelledLater_Stays") {
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory.path() / "s.plait";
    StoreOptions options;
    options.backend = "pread";
    Store store = Store::create(path, BaseMesh::build(icosahedron()), options, default_backends());
    add_base_positions(store);
    Digest committed;
    bool enough = false;
    SubdivideOptions what;
    what.levels = 4;
    what.executor = executor;
    what.level_done = [&](int level) {
      store.commit();
      committed = digest(store);
      enough = level == 2;
    };
    what.progress = [&](const Progress&) { return !enough; };
    CHECK_THROWS_AS(subdivide(store, what), Error);
    CHECK_THROWS_AS(store.commit(), Error);
    store.close();
    Store again = Store::open(path, {}, default_backends());
    CHECK(again.finest_level() == 2);
    CHECK(digest(again) == committed);
  }
}
