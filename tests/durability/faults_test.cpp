// Every file operation of a run fails once, for each of them in turn; or falls short everywhere.
#include "durability/faults.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdlib>
#include <optional>

#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

class LastCommit final : public CommitObserver {
 public:
  void committing(std::uint64_t version) override { in_flight_ = version; }
  void committed(std::uint64_t version) override { committed_ = in_flight_ = version; }
  bool allows(std::uint64_t version) const {
    return version == committed_ || version == in_flight_;
  }
  std::uint64_t committed() const { return committed_; }

 private:
  std::uint64_t committed_ = 0, in_flight_ = 0;
};

/// Runs with operation `failing` made to fail. False: there are not so many.
bool try_run(const std::string& backend, std::uint64_t failing, int error,
             FailingOperations::From from, const std::vector<Digest>& versions) {
  const TemporaryDirectory here(Medium::kMemory);
  const std::filesystem::path store = here.path() / "s.plait";
  LastCommit last;
  std::optional<Error> reported;
  bool failed = false;
  {
    FailingOperations operations(here.path(), failing, error, from);
    try {
      run_workload(store, backend, last);
    } catch (const Error& caught) {
      reported = caught;
    }
    failed = operations.failed();
  }
  if (!failed) {
    REQUIRE_FALSE(reported);
    return false;
  }
  CAPTURE(backend, failing, error, reported ? reported->what() : "nothing was reported");
  if (reported) {
    REQUIRE(reported->code() == (error == ENOSPC ? ErrorCode::kNoSpace : ErrorCode::kIo));
    REQUIRE(names(*reported, {here.path().string()}));
  }
  if (last.committed() == 0 && from == FailingOperations::From::kOne && reported)
    REQUIRE(file_names(here.path()).empty());
  const std::uint64_t version = version_found(store, versions);
  REQUIRE(last.allows(version));
  return true;
}

/// Every one, or in the short run one in `stride`.
std::uint64_t stride(std::uint64_t short_run) { return std::getenv("PLAIT_LONG") ? 1 : short_run; }

}  // namespace

TEST_CASE("Run_AnyOperationFails_IsReportedAndTheLastCommitIsThere") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory undisturbed(Medium::kMemory);
    const auto versions = digests_of_undisturbed_run(undisturbed.path() / "s.plait", backend);
    std::uint64_t tried = 0;
    for (const int error : {EIO, ENOSPC})
      for (const auto from :
           {FailingOperations::From::kOne, FailingOperations::From::kAllFromThere})
        for (std::uint64_t failing = tried % 7; try_run(backend, failing, error, from, versions);
             failing += stride(7))
          ++tried;
    CHECK(tried > 50);
  }
}

TEST_CASE("Run_EveryTransferShortAndEveryCallInterrupted_IsTheSame") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory undisturbed(Medium::kMemory), here(Medium::kMemory);
    const auto versions = digests_of_undisturbed_run(undisturbed.path() / "s.plait", backend);
    LastCommit last;
    {
      const ShortAndInterrupted operations(977);
      run_workload(here.path() / "s.plait", backend, last);
      CHECK(operations.operations() > 500);
    }
    CHECK(version_found(here.path() / "s.plait", versions) == versions.size() - 1);
  }
}

TEST_CASE("Commit_AfterOneThatFailed_IsRefusedUntilReopenedAndReadingGoesOn") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory here(Medium::kMemory);
    const std::filesystem::path path = here.path() / "s.plait";
    Store store = create_store(path, backend);
    add_sample(store, sample_schemas()[0], 2);
    store.commit();
    change_blocks(store, 0, 2, 1);
    {
      const FailingOperations operations(here.path(), 0, EIO,
                                         FailingOperations::From::kAllFromThere);
      CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kIo);
    }
    CHECK(read_level(store, 0, 1) == sample_level(store, sample_schemas()[0], 1));
    CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
    store.close();
    Store again = Store::open(path, {true}, default_backends());
    CHECK(again.sequence() == 1);
    CHECK(holds_sample(again, 0));
    change_blocks(again, 0, 2, 1);
    again.commit();
  }
}

/// The caller ignores that a commit failed and goes on changing blocks: none of it may reach what
/// either version needs, whichever of them the disk has.
TEST_CASE("Blocks_ChangedAfterACommitThatFailed_DoNotSpoilTheVersionOnDisk") {
  for (const std::string& backend : durable_backends()) {
    for (std::uint64_t operation = 0;; ++operation) {
      INFO(backend << ", operation " << operation);
      const TemporaryDirectory here(Medium::kMemory);
      const std::filesystem::path path = here.path() / "s.plait";
      Digest before, after;
      bool committed = true, reached = false;
      {
        Store store = create_store(path, backend);
        add_sample(store, sample_schemas()[0], 2);
        store.commit();
        before = digest(store);
        change_blocks(store, 0, 2, 1);
        after = digest(store);
        {
          const FailingOperations operations(here.path(), operation, EIO,
                                             FailingOperations::From::kOne);
          try {
            store.commit();
          } catch (const Error&) {
            committed = false;
          }
          reached = operations.failed();
        }
        if (!reached) break;
        try {
          change_blocks(store, 0, 2, 1);
          StoreAccess::pager(store).flush();
          CHECK(committed);
        } catch (const Error& error) {
          CHECK_FALSE(committed);
        }
      }
      Store again = Store::open(path, {true}, default_backends());
      const Digest found = digest(again);
      CHECK((found == after || (!committed && found == before)));
      CHECK(verify(again).damaged_count == 0);
    }
  }
}

TEST_CASE("Store_AfterACommitThatFailed_RefusesWritesAndCommitsUntilItIsReopened") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory here;
    const std::filesystem::path path = here.path() / "s.plait";
    {
      Store store = create_store(path, backend);
      add_sample(store, sample_schemas()[0], 2);
      store.commit();
      store.base_bytes(0)[0] ^= std::byte{1};
      {
        const FailingOperations operations(path / "manifest", 0, EIO,
                                           FailingOperations::From::kAllFromThere);
        CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kIo);
      }
      // The disk is well again, and what it holds is not known.
      CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
      CHECK(error_of([&] { change_blocks(store, 0, 2, 1); }).code() == ErrorCode::kBadState);
      CHECK(store.sequence() == 1);
    }
    Store again = Store::open(path, {true}, default_backends());
    CHECK(holds_sample(again, 0));
    again.base_bytes(0)[0] ^= std::byte{1};
    again.commit();
    CHECK(again.sequence() == 2);
  }
}

/// A slot whose sync failed may be read from the page cache and not be on the disk. Before the next
/// writer removes what only the version before needs, the slot must have been synced.
TEST_CASE("StoreOpen_ForWriting_MakesTheNewestSlotDurableBeforeAnythingGoes") {
  class Order final : public FileOperationHook {
   public:
    Order() { set_file_operation_hook(this); }
    ~Order() { set_file_operation_hook(nullptr); }
    Order(const Order&) = delete;
    Order& operator=(const Order&) = delete;
    Verdict before(const FileOperation&) noexcept override { return {}; }
    void after(const FileOperation& operation) noexcept override {
      using Kind = FileOperation::Kind;
      const bool manifest = operation.path.filename() == "manifest";
      if (manifest && operation.kind == Kind::kWrite) written = true;
      if (manifest && operation.kind == Kind::kSync) synced = written;
      if (operation.kind == Kind::kRemove) removed_before_sync = removed_before_sync || !synced;
      if (operation.kind == Kind::kRemove) removed = true;
    }
    bool written = false, synced = false, removed = false, removed_before_sync = false;
  };
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  {
    Store store = create_store(path, "pread");
    add_sample(store, sample_schemas()[0], 1);
    store.commit();
  }
  File(path / "version.9", OpenMode::kCreate);
  const Order order;
  Store::open(path, {true}, default_backends());
  CHECK(order.synced);
  CHECK(order.removed);
  CHECK_FALSE(order.removed_before_sync);
}

TEST_CASE("MappedLevel_CutShortBehindItsBack_IsAnError") {
  const TemporaryDirectory here(Medium::kMemory);
  const std::filesystem::path path = here.path() / "s.plait";
  {
    Store store = create_store(path, "mmap");
    add_sample(store, sample_schemas()[0], 3);
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  std::filesystem::resize_file(path / "attribute0.level03.1", 4096);
  CHECK(error_of([&] { read_level(store, 0, 3); }).code() == ErrorCode::kCorruption);
  CHECK(read_level(store, 0, 2) == sample_level(store, sample_schemas()[0], 2));
}

TEST_CASE("MappedLevel_WhoseReadFails_IsAnErrorAndNoSignal") {
  const TemporaryDirectory here(Medium::kMemory);
  const std::filesystem::path path = here.path() / "s.plait";
  const std::string name = "attribute0.level03.1";
  {
    Store store = create_store(path, "mmap");
    add_sample(store, sample_schemas()[0], 3);
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  {
    const FailingOperations disk(path / name, 0, EIO, FailingOperations::From::kAllFromThere);
    CHECK(error_of([&] { read_level(store, 0, 3); }).code() == ErrorCode::kIo);
  }
  // After the store has looked at the file's size, and before it looks at the first page.
  const BeforeOperation meanwhile(FileOperation::Kind::kRead, name,
                                  [&] { std::filesystem::resize_file(path / name, 0); });
  const Error error = error_of([&] { read_level(store, 0, 3); });
  CAPTURE(error.what());
  CHECK(error.code() == ErrorCode::kIo);
  CHECK(meanwhile.was_done());
  CHECK(read_level(store, 0, 2) == sample_level(store, sample_schemas()[0], 2));
}

}  // namespace plait::test
