// Replaces a store by another one. This must not happen while another process has the old store
// open, and the new store must never be lost.
#include "partial_output.h"

#include <catch2/catch.hpp>

#include "plait/backends/registry.h"
#include "plait/error.h"
#include "plait/store.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

StoreUuid make_store(const std::filesystem::path& path) {
  Store store = Store::create(path, BaseMesh::build(tetrahedron()), {}, default_backends());
  store.commit();
  return store.uuid();
}

StoreUuid uuid_of(const std::filesystem::path& path) {
  return Store::open(path, {}, default_backends()).uuid();
}

}  // namespace

TEST_CASE("ReplaceStore_ThatSomebodyHasOpened_LeavesBothAndIsBusy") {
  for (const bool writer : {false, true}) {
    const TemporaryDirectory here;
    const std::filesystem::path path = here.path() / "s.plait";
    const StoreUuid old = make_store(path);
    std::filesystem::path made;
    {
      PartialOutput output(path, Existing::kReplace);
      make_store(output.make());
      OpenOptions options;
      options.writable = writer;
      const Store holder = Store::open(path, options, default_backends());
      try {
        output.publish(true);
        FAIL("expected an error");
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kBusy);
        made = output.path();  // no later run removes this name as left over
        CHECK_THAT(error.what(), Catch::Contains(made.native()));
      }
    }
    CHECK(uuid_of(path) == old);
    CHECK(uuid_of(made) != old);
  }
}

TEST_CASE("ReplaceStore_ThatNobodyHolds_TakesItsName") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  make_store(path);
  PartialOutput output(path, Existing::kReplace);
  const StoreUuid made = make_store(output.make());
  output.publish(true);
  CHECK(uuid_of(path) == made);
  CHECK_FALSE(std::filesystem::exists(output.path()));
}

}  // namespace plait::test
