// Stores from a stranger: whatever links and forged files are in the directory, nothing outside of
// it is touched, and nothing in it that the newest version does not name.
#include <sys/stat.h>
#include <xxhash.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>

#include "engine/store/sample_store.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::byte>;

/// A store with two levels of attribute 0, the second one never written.
struct Store0 {
  explicit Store0(const std::string& backend = "pread") {
    Store store = Store::create(path, BaseMesh::build(random_sheet(5, 40)), sample_options(backend),
                                default_backends());
    add_sample(store, sample_schemas()[0], 1);
    store.add_level(0);
    store.commit();
    level_bytes = StoreAccess::level_file(store, 0, 1).geometry.block_bytes(0);
  }
  ErrorCode error_of_opening(bool writable) const {
    return error_of([&] { Store::open(path, {writable}, default_backends()); }).code();
  }

  TemporaryDirectory directory;
  fs::path path = directory.path() / "s.plait";
  std::uint64_t level_bytes = 0;  ///< of block 0 of level 1
};

void write_file(const fs::path& path, const Bytes& bytes) {
  File(path, OpenMode::kCreate).write_at(0, bytes);
}

}  // namespace

TEST_CASE("Store_AnyFileALinkOrAFifo_IsRefusedByNameAtOnceAndTheTargetUntouched") {
  for (const std::string& backend : durable_backends()) {
    const Store0 store(backend);
    for (const std::string& name : file_names(store.path)) {
      const fs::path file = store.path / name, aside = store.directory.path() / name;
      fs::rename(file, aside);
      const Bytes before = file_bytes(aside);
      for (const bool fifo : {false, true}) {
        if (fifo)
          REQUIRE(::mkfifo(file.c_str(), 0600) == 0);
        else
          fs::create_symlink(aside, file);
        for (const bool writable : {false, true}) {
          if (name == "lock" && !writable) continue;  // a reader needs no lock of the store
          CAPTURE(backend, name, fifo, writable);
          const Error error =
              error_of([&] { Store::open(store.path, {writable}, default_backends()); });
          CHECK(error.code() == ErrorCode::kCorruption);
          CHECK(names(error, {file.string(), fifo ? "a FIFO" : "a symbolic link"}));
        }
        fs::remove(file);
      }
      CHECK(file_bytes(aside) == before);
      fs::rename(aside, file);
    }
    CHECK(Store::open(store.path, {}, default_backends()).sequence() == 1);
  }
}

TEST_CASE("StoreOpen_ForWritingWhatIsNoStore_LeavesItsLockFileAlone") {
  const TemporaryDirectory here;
  for (const char* name : {"manifest", "lock", "thesis.tex"})
    std::ofstream(here.path() / name) << "mine";
  CHECK(error_of([&] { Store::open(here.path(), {true}, default_backends()); }).code() ==
        ErrorCode::kCorruption);
  CHECK(file_bytes(here.path() / "lock").size() == 4);
  CHECK(file_names(here.path()).size() == 3);
}

TEST_CASE("StoreCommit_OfAWriterWhoseLockIsGone_IsRefusedBecauseAnotherMayWrite") {
  const Store0 store;
  Store first = Store::open(store.path, {true}, default_backends());
  fs::remove(store.path / "lock");
  Store second = Store::open(store.path, {true}, default_backends());
  const Error error = error_of([&] { commit_anew(first); });
  CHECK(error.code() == ErrorCode::kBusy);
  CHECK(names(error, {(store.path / "lock").string()}));
  commit_anew(second);
  second.close();
  CHECK(Store::open(store.path, {}, default_backends()).sequence() == 2);
}

TEST_CASE("StoreOpen_ForWriting_RemovesNothingWhoseNameIsNotAVersions") {
  const Store0 store;
  const std::vector<std::string> theirs = {"attributes.txt",     "attribute0.level1.1",
                                           "attribute.base.1",   "attribute0.base.",
                                           "version.x",          "version.",
                                           "attribute0.level01", "attribute0.level01.bak"};
  const std::vector<std::string> left = {"attribute3.level02.1", "attribute0.base.9", "version.12"};
  for (const auto& list : {theirs, left})
    for (const std::string& name : list) write_file(store.path / name, Bytes(3));
  Store::open(store.path, {true}, default_backends());
  for (const std::string& name : theirs) CHECK(fs::exists(store.path / name));
  for (const std::string& name : left) CHECK_FALSE(fs::exists(store.path / name));
}

TEST_CASE("StoreCreate_WhereAManifestIsAllZeros_IsRefused") {
  const Store0 store;
  std::ofstream(store.path / "manifest") << std::string(8192, '\0');
  CHECK(Store::has_commit(store.path));
  CHECK(error_of([&] {
          Store::create(store.path, BaseMesh::build(two_triangles()), sample_options("pread"),
                        default_backends());
        }).code() == ErrorCode::kInvalidArgument);
  CHECK(fs::exists(store.path / "version.1"));
}

TEST_CASE("StoreCommit_AtTheLastVersionThatThereCanBe_IsRefusedAndKeepsIt") {
  const Store0 store;
  Manifest manifest = read_manifest(Directory(store.path));
  const auto rename = [&](const std::string& prefix) {
    fs::rename(store.path / (prefix + std::to_string(manifest.sequence)),
               store.path / (prefix + std::to_string(kMaxSequence)));
  };
  rename("version.");
  rename("attribute0.base.");
  manifest.sequence = kMaxSequence;
  {
    File file(store.path / "manifest", OpenMode::kReadWrite);
    write_manifest(file, manifest);
  }
  {
    Store writer = Store::open(store.path, {true}, default_backends());
    CHECK(error_of([&] { commit_anew(writer); }).code() == ErrorCode::kNotSupported);
  }
  CHECK(Store::open(store.path, {}, default_backends()).sequence() == kMaxSequence);
  ++manifest.sequence;
  ManifestSlot slot = encode_manifest(manifest);
  CHECK(error_of([&] { decode_manifest(slot, "m"); }).code() == ErrorCode::kCorruption);
}

TEST_CASE("Store_MovedWhileItIsWritten_GoesOnInItsOwnDirectory") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory here;
    const fs::path path = here.path() / "run.plait", moved = here.path() / "old.plait";
    const auto create = [&](std::uint32_t seed) {
      Store store = Store::create(path, BaseMesh::build(random_sheet(seed, 40)),
                                  sample_options(backend), default_backends());
      add_sample(store, sample_schemas()[0], 1);
      store.commit();
      return store;
    };
    Digest newer, older;
    {
      Store writer = create(5);
      fs::rename(path, moved);
      {
        Store other = create(6);
        add_sample(other, sample_schemas()[1], 2);
        other.commit();
        newer = digest(other);
      }
      // Levels are made, blocks overwritten in place, files of older versions removed.
      add_sample(writer, sample_schemas()[1], 2);
      {
        const PinnedBlock block = StoreAccess::open_session(writer).pin(
            StoreAccess::level_file(writer, 0, 1), 0, Access::kUpdate);
        for (std::byte& byte : block.bytes()) byte ^= std::byte{1};
      }
      commit_anew(writer);
      commit_anew(writer);
      older = digest(writer);
    }
    Store first = Store::open(moved, {}, default_backends());
    Store second = Store::open(path, {}, default_backends());
    CHECK(digest(first) == older);
    CHECK(digest(second) == newer);
    CHECK(first.sequence() == 3);
    CHECK(second.sequence() == 2);
  }
}

}  // namespace plait::test
