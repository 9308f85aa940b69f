// Replaces a store by another one. This must not happen while another process has the old store
// open, and the new store must never be lost.
#include "store/unpublished_store.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "io/made_mark.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "store/left_overs.h"
#include "store/new_output.h"
#include "support/answering_operations.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/killing_operations.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

StoreUuid make_store(const std::filesystem::path& path) {
  Store store = Store::create(path, BaseMesh::build(tetrahedron()), {}, default_backends());
  store.commit();
  return store.info().uuid;
}

/// While it lives, files of this name cannot be removed: they are busy on a network, or immutable.
class FailingRemoval final : public FileOperationHook {
 public:
  explicit FailingRemoval(std::string name) : name_(std::move(name)) {
    set_file_operation_hook(this);
  }
  ~FailingRemoval() { set_file_operation_hook(nullptr); }
  FailingRemoval(const FailingRemoval&) = delete;
  FailingRemoval& operator=(const FailingRemoval&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    Verdict verdict;
    if (operation.kind == FileOperation::Kind::kRemove && operation.path.filename() == name_)
      verdict.error = EBUSY;
    return verdict;
  }
  void after(const FileOperation&) noexcept override {}

 private:
  const std::string name_;
};

StoreUuid uuid_of(const std::filesystem::path& path) {
  return Store::open(path, {}, default_backends()).info().uuid;
}

}  // namespace

TEST_CASE("ReplaceStore_ThatSomebodyHasOpened_LeavesBothAndIsBusy") {
  for (const bool writer : {false, true}) {
    const TemporaryDirectory here;
    const std::filesystem::path path = here.path() / "s.plait";
    const StoreUuid old = make_store(path);
    std::filesystem::path made;
    {
      UnpublishedStore output(path, Existing::kReplace, {});
      make_store(output.make());
      const Store holder = Store::open(path, {.writable = writer}, default_backends());
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

TEST_CASE("ReplaceStore_ThatAnotherProcessReplacesMeanwhile_StaysBesideAndSaysSo") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  make_store(path);
  UnpublishedStore output(path, Existing::kReplace, {});
  const StoreUuid made = make_store(output.make());
  StoreUuid faster{};
  const BeforeOperation other(FileOperation::Kind::kExchange, output.path().filename(), [&] {
    std::filesystem::rename(path, here.path() / "old.plait");
    faster = make_store(path);
  });
  const Error error = error_of([&] { output.publish(true); });
  CHECK(other.was_done());
  CHECK(error.code() == ErrorCode::kBusy);
  CHECK_THAT(error.what(), Catch::Contains("another process has replaced the store") &&
                               Catch::Contains(output.path().native()));
  CHECK(uuid_of(path) == faster);
  CHECK(uuid_of(output.path()) == made);
}

TEST_CASE("ReplaceStore_ThatNobodyHolds_TakesItsName") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  make_store(path);
  UnpublishedStore output(path, Existing::kReplace, {});
  const StoreUuid made = make_store(output.make());
  output.publish(true);
  CHECK(uuid_of(path) == made);
  CHECK_FALSE(std::filesystem::exists(output.path()));
}

TEST_CASE("ReplaceStore_KilledBeforeAnyOperation_LeavesTheOldStoreOrTheNew") {
  bool killed = true;
  std::uint64_t old_ones = 0, new_ones = 0, left_overs = 0;
  for (std::uint64_t operations = 0; killed; ++operations) {
    const TemporaryDirectory here(Medium::kMemory);
    const std::filesystem::path path = here.path() / "s.plait";
    const StoreUuid old = make_store(path);
    std::ofstream(path / "notes") << "the user's";
    killed = run_and_kill_before(operations, [&] {
      UnpublishedStore output(path, Existing::kReplace, {});
      make_store(output.make());
      output.publish(true);
    });
    CAPTURE(operations);
    const bool is_old = uuid_of(path) == old;
    CHECK((killed || !is_old));
    ++(is_old ? old_ones : new_ones);
    // What is left goes, but for what plait did not make.
    const Directory directory(here.path());
    for (const LeftOver& left_over : find_left_overs(directory)) {
      CHECK_FALSE(left_over.in_use);
      CHECK(remove_left_over(directory, left_over) == left_over.foreign.empty());
      ++left_overs;
    }
    bool kept = std::filesystem::exists(path / "notes");
    for (const std::string& name : directory.names())
      kept = kept || std::filesystem::exists(here.path() / name / "notes");
    CHECK(kept);
    CHECK((directory.names().size() == 1 || !std::filesystem::exists(path / "notes")));
  }
  CHECK(old_ones > 10);
  CHECK(new_ones > 5);
  CHECK(left_overs > 10);
}

namespace {

/// A file system that cannot exchange names, or refuses to rename one name.
class OtherFileSystem final : public FileOperationHook {
 public:
  explicit OtherFileSystem(std::filesystem::path unmovable = {}, int error = EXDEV)
      : unmovable_(std::move(unmovable)), error_(error) {
    set_file_operation_hook(this);
  }
  ~OtherFileSystem() { set_file_operation_hook(nullptr); }
  Verdict before(const FileOperation& operation) noexcept override {
    if (operation.kind == FileOperation::Kind::kExchange) return {.error = EINVAL};
    const bool refused = operation.kind == FileOperation::Kind::kRename && !unmovable_.empty() &&
                         operation.path == unmovable_;
    return {.error = refused ? error_ : 0};
  }
  void after(const FileOperation&) noexcept override {}

 private:
  std::filesystem::path unmovable_;
  int error_;
};

}  // namespace

TEST_CASE("ReplaceStore_WhereNamesCannotBeExchanged_TakesTwoRenamesAndSaysSo") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  make_store(path);
  std::ofstream(path / "notes") << "the user's";
  std::vector<std::string> told;
  const OtherFileSystem hook;
  UnpublishedStore output(path, Existing::kReplace,
                          [&](const std::string& what) { told.push_back(what); });
  const StoreUuid made = make_store(output.make());
  REQUIRE(told.size() == 1);  // before the work
  CHECK_THAT(told[0], Catch::Contains("cannot exchange two names"));
  output.publish(true);
  CHECK(uuid_of(path) == made);
  CHECK(std::filesystem::exists(path / "notes"));
  CHECK(Directory(here.path()).names() == std::vector<std::string>{"s.plait"});
}

TEST_CASE("ReplaceStore_WhoseDirectoryCannotBeRenamed_StaysBesideAndSaysSo") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  const StoreUuid old = make_store(path);
  StoreUuid made{};
  std::filesystem::path beside;
  {
    UnpublishedStore output(path, Existing::kReplace, {});
    made = make_store(output.make());
    const OtherFileSystem hook(path);
    const Error error = error_of([&] { output.publish(true); });
    beside = output.path();
    CHECK_THAT(error.what(), Catch::Contains("complete and stays at " + beside.native()));
  }
  CHECK(uuid_of(path) == old);
  CHECK(uuid_of(beside) == made);
}

TEST_CASE("NewStore_WhereNothingCanBeRenamed_StaysAndNoRunRemovesIt") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  StoreUuid made{};
  std::filesystem::path beside;
  {
    const AnsweringOperations no_renaming(FileOperation::Kind::kRename, EROFS);
    UnpublishedStore output(path, Existing::kRefuse, {});
    made = make_store(output.make());
    const Error error = error_of([&] { output.publish(true); });
    beside = output.path();
    CHECK_THAT(error.what(), Catch::Contains("complete and stays at " + beside.native()));
  }
  remove_left_overs_of(path, {});
  CHECK(find_left_overs(Directory(here.path())).empty());
  CHECK(uuid_of(beside) == made);
}

// moby/moby#25409, conda/conda#6711: a directory of a lower layer of an overlay. A mount point:
// EBUSY.
TEST_CASE("ReplaceStore_ThatCanHaveNoOtherName_IsRefusedBeforeTheWork") {
  for (const int error_number : {EXDEV, EBUSY}) {
    const TemporaryDirectory here;
    const std::filesystem::path path = here.path() / "s.plait";
    const StoreUuid old = make_store(path);
    {
      const OtherFileSystem hook(path, error_number);
      UnpublishedStore output(path, Existing::kReplace, {});
      const Error error = error_of([&] { output.make(); });
      CHECK(error.code() == ErrorCode::kNotSupported);
      CHECK_THAT(error.what(), Catch::Contains("remove it before"));
    }
    CHECK(uuid_of(path) == old);
    CHECK(Directory(here.path()).names() == std::vector<std::string>{"s.plait"});
  }
}

TEST_CASE("ReplaceStore_KilledBetweenTwoRenames_IsPutBackByTheNextRun") {
  bool killed = true;
  std::uint64_t put_back = 0;
  for (std::uint64_t operations = 0; killed; ++operations) {
    const TemporaryDirectory here(Medium::kMemory);
    const std::filesystem::path path = here.path() / "s.plait";
    const StoreUuid old = make_store(path);
    const auto replace = [&] {
      UnpublishedStore output(path, Existing::kReplace, {});
      make_store(output.make());
      output.publish(true);
    };
    killed = run_and_kill_before(operations, replace, EINVAL);
    CAPTURE(operations);
    std::vector<std::string> told;
    remove_left_overs_of(path, [&](const std::string& what) { told.push_back(what); });
    for (const std::string& what : told)
      put_back += what.find("put back") != std::string::npos ? 1u : 0u;
    const StoreUuid found = uuid_of(path);
    CHECK((killed || found != old));
  }
  CHECK(put_back > 0);
}

TEST_CASE("NewDirectory_KilledBeforeAnyOperation_LeavesNothingThatStays") {
  bool killed = true;
  for (std::uint64_t operations = 0; killed; ++operations) {
    const TemporaryDirectory here(Medium::kMemory);
    const std::filesystem::path path = here.path() / "n.plan";
    const auto make = [&] {
      make_new_directory(
          path, {}, [](const Directory& made) { made.remove("plan"); },
          [](const Directory& made) { File(made, "plan", OpenMode::kCreate).close(); });
    };
    killed = run_and_kill_before(operations, make);
    CAPTURE(operations);
    remove_left_overs_of(path, {});
    const std::size_t there = std::filesystem::exists(path) ? 1 : 0;
    CHECK(Directory(here.path()).names().size() == there);
    if (there == 1) CHECK(std::filesystem::exists(path / "plan"));
    if (!killed) CHECK(Directory(path).names() == std::vector<std::string>{"plan"});
  }
}

TEST_CASE("LeftOver_OneOfWhoseFilesCannotBeRemoved_KeepsItsProofAndIsRemovedLater") {
  for (const std::string proof : {"manifest", "plait-made"}) {
    CAPTURE(proof);
    const TemporaryDirectory here(Medium::kMemory);
    const std::string name = "s.plait.partial-999991";
    make_store(here.path() / name);
    if (proof == "plait-made") {
      std::filesystem::remove(here.path() / name / "manifest");
      write_made_mark(Directory(here.path() / name));
    }
    const Directory directory(here.path());
    {
      const std::string file = "base.mesh";
      REQUIRE(std::filesystem::exists(here.path() / name / file));
      const FailingRemoval fails(file);
      const std::vector<LeftOver> found = find_left_overs(directory);
      REQUIRE(found.size() == 1);
      CHECK_FALSE(remove_left_over(directory, found[0]));
      CHECK(std::filesystem::exists(here.path() / name / proof));
      std::vector<std::string> warnings;
      remove_left_overs_of(here.path() / "s.plait",
                           [&](const std::string& text) { warnings.push_back(text); });
      REQUIRE(warnings.size() == 1);
      CHECK(warnings[0].find("cannot be removed") != std::string::npos);
    }
    const std::vector<LeftOver> found = find_left_overs(directory);
    REQUIRE(found.size() == 1);
    CHECK(remove_left_over(directory, found[0]));
    CHECK(directory.names().empty());
  }
}

}  // namespace plait::test
