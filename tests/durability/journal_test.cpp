// The rollback journal, from outside: when there is one, what it puts back, and what a damaged one
// does. Hostile ones: tests/fuzz/journal.cpp.
#include <catch2/catch.hpp>
#include <fstream>

#include "durability/faults.h"
#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "plait/backends/registry.h"
#include "plait/verify.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

class NobodyObserves final : public CommitObserver {
 public:
  void committing(std::uint64_t) override {}
  void committed(std::uint64_t) override {}
};

std::vector<Setup> setups_in_place() {
  std::vector<Setup> setups = setups_on_disk();
  std::erase_if(setups, [](const Setup& setup) { return !setup.in_place(); });
  return setups;
}

/// A store whose last changes were never committed, and the digests of its versions.
struct Abandoned {
  explicit Abandoned(const Setup& setup) {
    const NoWaiting no_waiting;
    const TemporaryDirectory undisturbed;
    versions = digests_of_undisturbed_run(undisturbed.path() / "s.plait", setup);
    NobodyObserves observer;
    run_workload(path, setup, observer);
  }
  std::uint64_t last_version() const { return versions.size() - 1; }
  /// A copy that may be changed.
  fs::path copy() const {
    const fs::path to = here.path() / "copy.plait";
    fs::remove_all(to);
    fs::copy(path, to);
    return to;
  }

  TemporaryDirectory here;
  fs::path path = here.path() / "s.plait";
  std::vector<Digest> versions;
};

Store small_store(const fs::path& path, const Setup& setup, Durability durability) {
  Store store = create_store(path, setup, durability);
  add_sample(store, sample_schemas()[0], 2);
  store.commit();
  return store;
}

}  // namespace

TEST_CASE("Journal_OfAnAbandonedStore_IsWhatBringsItBack") {
  for (const Setup& setup : setups_in_place()) {
    CAPTURE(setup.label());
    const Abandoned store(setup);
    REQUIRE(fs::exists(store.path / "journal"));
    const fs::path without = store.copy();
    fs::remove(without / "journal");
    {
      Store damaged = Store::open(without, {}, default_backends());
      CHECK(verify(damaged).damaged_count > 0);
    }
    CHECK(version_found(store.copy(), store.versions) == store.last_version());
    // By a reader, too.
    const fs::path read = store.copy();
    CHECK(Store::open(read, {}, default_backends()).sequence() == store.last_version());
    CHECK_FALSE(fs::exists(read / "journal"));
  }
}

TEST_CASE("Journal_RemovedAsAReaderOpensIt_IsNoError") {
  for (const Setup& setup : setups_in_place()) {
    CAPTURE(setup.label());
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait", journal = path / "journal";
    small_store(path, setup, Durability::kCommit).close();
    // A journal of another version has no meaning. A writer removes it.
    std::ofstream(journal) << "of another version";
    const BeforeOperation writer(FileOperation::Kind::kOpen, "journal",
                                 [&] { fs::remove(journal); });
    CHECK_NOTHROW(Store::open(path, {}, default_backends()));
    CHECK(writer.was_done());
  }
}

TEST_CASE("Journal_ItsBuffer_IsSubtractedFromTheBudget") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  for (const Setup& setup : setups_in_place()) {
    CAPTURE(setup.label());
    fs::remove_all(path);
    small_store(path, setup, Durability::kCommit).close();
    const auto budget_of_frames = [&](std::uint64_t budget_bytes, Durability durability) {
      OpenOptions options;
      options.writable = true;
      options.overwriting = Overwriting::kInPlace;
      options.durability = durability;
      options.budget_bytes = budget_bytes;
      return Store::open(path, options, default_backends()).pager().budget_bytes();
    };
    // docs/backends.md, "One volume per store".
    for (const std::uint64_t budget_bytes : {std::uint64_t{1} << 20, std::uint64_t{64} << 20}) {
      const std::uint64_t buffer_bytes = std::min(budget_bytes / 8, std::uint64_t{1} << 20);
      CHECK(budget_of_frames(budget_bytes, Durability::kNone) ==
            budget_of_frames(budget_bytes, Durability::kCommit) + buffer_bytes);
    }
  }
}

TEST_CASE("Journal_AnyByteFlipped_IsFoundOrHarmless") {
  const Abandoned store(Setup("pread", Overwriting::kInPlace));
  const std::vector<std::byte> bytes = file_bytes(store.path / "journal");
  std::uint64_t found = 0;
  // All of the header and the first record's, and places all over the rest.
  for (std::uint64_t at = 0; at < bytes.size(); at += at < 100 ? 1 : 97) {
    const NoWaiting no_waiting;
    const fs::path copy = store.copy();
    overwrite_byte(copy / "journal", at, bytes[at] ^ std::byte{0x40});
    CAPTURE(at);
    try {
      Store opened = Store::open(copy, {}, default_backends());
      if (verify(opened).damaged_count > 0)
        ++found;
      else
        REQUIRE(digest(opened) == store.versions.back());
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kCorruption);
      ++found;
    }
  }
  CHECK(found > 100);
}

TEST_CASE("Journal_OfAnOlderVersion_MeansNothingAndIsRemoved") {
  for (const Setup& setup : setups_in_place()) {
    CAPTURE(setup.label());
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    Store store = small_store(path, setup, Durability::kCommit);
    change_blocks(store, 0, 1, 1);
    store.pager().flush();
    const std::vector<std::byte> journal = file_bytes(path / "journal");
    store.commit();
    CHECK_FALSE(fs::exists(path / "journal"));
    const Digest committed = digest(store);
    store.close();
    File(path / "journal", OpenMode::kCreate).write_at(0, journal);
    CHECK([&] {
      Store reader = Store::open(path, {}, default_backends());
      return digest(reader) == committed;
    }());
    CHECK([&] {
      Store writer = Store::open(path, {true}, default_backends());
      return digest(writer) == committed;
    }());
    CHECK_FALSE(fs::exists(path / "journal"));
  }
}

TEST_CASE("Journal_WhereNoneIsNeeded_IsNotMade") {
  for (const Setup& setup : setups_on_disk()) {
    CAPTURE(setup.label());
    const TemporaryDirectory here;
    // Levels that no commit knows yet.
    Store fresh = small_store(here.path() / "fresh.plait", setup, Durability::kCommit);
    fresh.add_level(0);
    write_level(fresh, 0, 3, sample_level(fresh, sample_schemas()[0], 3));
    change_blocks(fresh, 0, 3, 1);
    fresh.pager().flush();
    CHECK_FALSE(fs::exists(here.path() / "fresh.plait" / "journal"));
    // Scratch.
    Store scratch = small_store(here.path() / "scratch.plait", setup, Durability::kNone);
    change_blocks(scratch, 0, 1, 1);
    scratch.pager().flush();
    CHECK_FALSE(fs::exists(here.path() / "scratch.plait" / "journal"));
  }
}

TEST_CASE("Journal_ThatCannotBeWritten_LeavesTheBlockAlone") {
  for (const Setup& setup : setups_in_place()) {
    CAPTURE(setup.label());
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    Store store = small_store(path, setup, Durability::kCommit);
    {
      const FailingOperations full(path / "journal", 0, ENOSPC,
                                   FailingOperations::From::kAllFromThere);
      const Error error = error_of([&] {
        change_blocks(store, 0, 2, 1);
        store.pager().flush();
      });
      CHECK(error.code() == ErrorCode::kNoSpace);
      CHECK(names(error, {(path / "journal").string()}));
    }
    store.close();
    Store again = Store::open(path, {}, default_backends());
    CHECK(holds_sample(again, 0));
  }
}

}  // namespace plait::test
