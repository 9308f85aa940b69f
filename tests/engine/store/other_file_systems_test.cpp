// Stores on file systems without locks, and on those that map no files.
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <string>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/notices.h"
#include "plait/notes.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/verify.h"
#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

Store made_store(const fs::path& path, const char* backend = "pread") {
  Store store =
      Store::create(path, BaseMesh::build(tetrahedron()), {.backend = backend}, default_backends());
  store.add_level(store.add_attribute(schema_of<float>("value")));
  store.commit();
  return store;
}

void commit_another(Store& store) {
  store.notes().set_text("title", std::to_string(store.sequence()));
  store.commit();
}

}  // namespace

TEST_CASE("MmapStore_WhereNoFileIsMapped_IsReadByPreadAndSaysSo") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  const Digest expected = digest(made_store(path, "mmap"));
  for (const int error : {ENODEV, ENOSYS, EOPNOTSUPP}) {
    CAPTURE(error);
    const AnsweringOperations hook(FileOperation::Kind::kMap, error);
    const Store store = Store::open(path, {}, default_backends());
    REQUIRE(notices(store).size() == 1);
    CHECK_THAT(notices(store)[0],
               Catch::Contains("map " + path.native()) && Catch::Contains("; using pread instead"));
    CHECK(digest(store) == expected);
    CHECK(verify(store).damaged.empty());
    const Reader reader(store);
    const PinnedVertices pinned = reader.pin_vertices("value", 1, 0, 3);
    CHECK(pinned.bytes().size() == 3 * sizeof(float));
  }
  const AnsweringOperations hook(FileOperation::Kind::kMap, EACCES);
  CHECK(error_of([&] { Store::open(path, {}, default_backends()); }).code() == ErrorCode::kIo);
}

TEST_CASE("StoreWithoutLocks_IsReadAndWrittenAndSaysWhatIsMissing") {
  for (const int error : {ENOLCK, ENOSYS, EOPNOTSUPP}) {
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    const AnsweringOperations hook(FileOperation::Kind::kLock, error);
    CAPTURE(error);
    {
      Store writer = made_store(path);
      REQUIRE(notices(writer).size() == 1);
      CHECK_THAT(notices(writer)[0], Catch::Contains("has no locks"));
      const Store reader = Store::open(path, {}, default_backends());
      CHECK(notices(reader).empty());
      for (int commits = 0; commits < 3; ++commits) commit_another(writer);
      CHECK(reader.sequence() == 1);
    }
    // A reader on another machine may need any of them.
    for (const char* name : {"version.1", "version.2", "version.3", "version.4"})
      CHECK(fs::exists(path / name));
    Store again = Store::open(path, {.writable = true}, default_backends());
    CHECK(notices(again).size() == 1);
    commit_another(again);
    CHECK(fs::exists(path / "version.1"));
  }
}

TEST_CASE("StoreWithLocks_AfterOneWithout_RemovesOldVersions") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  {
    const AnsweringOperations hook(FileOperation::Kind::kLock, ENOLCK);
    Store writer = made_store(path);
    for (int commits = 0; commits < 3; ++commits) commit_another(writer);
  }
  REQUIRE(fs::exists(path / "version.1"));
  Store writer = Store::open(path, {.writable = true}, default_backends());
  CHECK(notices(writer).empty());
  CHECK_FALSE(fs::exists(path / "version.1"));
  CHECK(writer.sequence() == 4);
}

}  // namespace plait::test
