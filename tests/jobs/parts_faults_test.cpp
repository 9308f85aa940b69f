// File systems that fail under parts and joins: one operation or all from there on fail (EIO,
// ESTALE), transfers are short and interrupted, and what another machine made is not visible yet.
// An error leaves nothing that counts, and the same command again ends well.
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "durability/faults.h"
#include "io/file_operations.h"
#include "jobs/pass_surfaces.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::passes {
namespace {

using From = FailingOperations::From;
constexpr std::uint32_t kShards = 3;

/// While it lives, files of these names are not there for this process: another machine has made
/// them, and the file system shows them later.
class NotVisibleYet final : public FileOperationHook {
 public:
  explicit NotVisibleYet(std::set<std::string> names) : names_(std::move(names)) {
    set_file_operation_hook(this);
  }
  ~NotVisibleYet() { set_file_operation_hook(nullptr); }
  NotVisibleYet(const NotVisibleYet&) = delete;
  NotVisibleYet& operator=(const NotVisibleYet&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    const bool late = operation.kind == FileOperation::Kind::kOpen &&
                      names_.contains(operation.path.filename().native());
    return late ? Verdict{ENOENT} : Verdict{};
  }
  void after(const FileOperation&) noexcept override {}

 private:
  const std::set<std::string> names_;
};

/// A plan over a small mesh.
struct Planned {
  TemporaryDirectory here{Medium::kMemory};
  Surfaces on = surfaces_of(here.path(), random_sheet(5, 12));
  std::filesystem::path plan;

  Planned() {
    on.max_slot_bytes = std::nullopt;
    on.levels = 2;
  }
  std::string make(std::uint32_t part) const {
    return make_part(plan, part, {}, default_backends()).digest;
  }
  std::size_t directories_of(std::uint32_t part) const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(plan))
      count += entry.path().filename().native().starts_with("part." + std::to_string(part) + "-");
    return count;
  }
  void forget(std::uint32_t part) const {
    std::filesystem::remove(plan / ("done." + std::to_string(part)));
    while (directories_of(part) > 0) std::filesystem::remove_all(directory_of(plan, part));
  }
};

struct PlannedSubdivision : Planned {
  PlannedSubdivision() { plan = on.plan_shards(kShards); }
};

/// Of the first version of a store.
struct PlannedPasses : Planned {
  std::string before;  ///< the store's digest
  PlannedPasses() {
    on.make_shards(kShards);
    before = digest_of(on.sharded());
    plan = on.plan(kSmooth);
  }
};

/// Calls work(number) with operation `number` failing, for each operation that it does. Returns how
/// many failed.
std::uint64_t with_each_failing(const std::filesystem::path& root, int error, From from,
                                const std::function<void()>& work,
                                const std::function<void(const Error*)>& check) {
  const std::uint64_t step = unless_sanitized<std::uint64_t>(1, 7);
  for (std::uint64_t number = 0;; number += step) {
    CAPTURE(number, error);
    bool failed = false, threw = false;
    try {
      FailingOperations hook(root, number, error, from);
      try {
        work();
      } catch (const Error& thrown) {
        threw = true;
        set_file_operation_hook(nullptr);
        check(&thrown);
      }
      failed = hook.failed();
    } catch (const std::exception& other) {
      FAIL(other.what());
    }
    if (!threw) check(nullptr);
    if (!failed) return number;
  }
}

/// Makes part 1 with each of its file operations failing, and then again.
void check_part(const Planned& planned, int error, From from,
                const std::function<void()>& check_store) {
  const std::string expected = planned.make(1);
  planned.forget(1);
  const auto work = [&] {
    const std::string made = planned.make(1);  // CHECK would catch its errors
    CHECK(made == expected);
  };
  const std::uint64_t operations =
      with_each_failing(planned.here.path(), error, from, work, [&](const Error* thrown) {
        if (thrown) {
          INFO(thrown->what());
          CHECK(thrown->code() == ErrorCode::kIo);
        }
        check_store();
        // done.1 may be there after an error: then it is complete.
        CHECK(planned.make(1) == expected);
        CHECK(planned.directories_of(1) == 1);
        planned.forget(1);
      });
  CHECK(operations > 30);
}

}  // namespace

TEST_CASE("Part_FileOperationsThatFail_LeaveNoPartOrTheRightOne") {
  const PlannedSubdivision planned;
  SECTION("one operation, EIO") {
    check_part(planned, EIO, From::kOne, [] {});
  }
  SECTION("all from there on, ESTALE") {
    check_part(planned, ESTALE, From::kAllFromThere, [] {});
  }
}

TEST_CASE("PassPart_FileOperationsThatFail_LeaveNoPartOrTheRightOne") {
  const PlannedPasses planned;
  const auto store_is_as_before = [&] { CHECK(digest_of(planned.on.sharded()) == planned.before); };
  SECTION("one operation, EIO") { check_part(planned, EIO, From::kOne, store_is_as_before); }
  SECTION("one operation, ESTALE") { check_part(planned, ESTALE, From::kOne, store_is_as_before); }
  SECTION("all from there on, ESTALE") {
    check_part(planned, ESTALE, From::kAllFromThere, store_is_as_before);
  }
}

TEST_CASE("Join_FileOperationsThatFail_LeaveNoStoreOrTheWholeOne", "[threads]") {
  const PlannedSubdivision planned;
  make_parts(planned.plan);
  const std::filesystem::path store = planned.on.sharded();
  REQUIRE(join(planned.plan, store).has_store);
  const std::string expected = digest_of(store);
  std::filesystem::remove_all(store);
  const auto check_fault = [&](int error, From from) {
    const auto work = [&] { join(planned.plan, store); };
    const std::uint64_t operations =
        with_each_failing(planned.here.path(), error, from, work, [&](const Error* thrown) {
          if (thrown) {
            INFO(thrown->what());
            CHECK(thrown->code() == ErrorCode::kIo);
          }
          if (!std::filesystem::exists(store)) CHECK(join(planned.plan, store).has_store);
          CHECK(digest_of(store) == expected);
          std::filesystem::remove_all(store);
        });
    CHECK(operations > 30);
  };
  SECTION("one operation, EIO") { check_fault(EIO, From::kOne); }
  SECTION("all from there on, ESTALE") { check_fault(ESTALE, From::kAllFromThere); }
}

TEST_CASE("PassJoin_FileOperationsThatFail_LeaveOneOfTheTwoVersions") {
  const PlannedPasses planned;
  make_parts(planned.plan);
  const std::filesystem::path store = planned.on.sharded(), kept = planned.here.path() / "kept";
  std::filesystem::copy(store, kept, std::filesystem::copy_options::recursive);
  REQUIRE(join(planned.plan, store).has_store);
  const std::string after = digest_of(store);
  REQUIRE(after != planned.before);
  const auto restore = [&] {
    std::filesystem::remove_all(store);
    std::filesystem::copy(kept, store, std::filesystem::copy_options::recursive);
  };
  restore();
  const auto check_fault = [&](int error, From from) {
    bool has_store = false;
    const auto work = [&] {
      has_store = false;
      has_store = join(planned.plan, store).has_store;
    };
    const std::uint64_t operations =
        with_each_failing(planned.here.path(), error, from, work, [&](const Error* thrown) {
          if (thrown) {
            INFO(thrown->what());
            CHECK(thrown->code() == ErrorCode::kIo);
          }
          const std::string found = digest_of(store);
          CHECK((found == after || (!has_store && found == planned.before)));
          CHECK(join(planned.plan, store).has_store);
          CHECK(digest_of(store) == after);
          restore();
        });
    CHECK(operations > 30);
  };
  SECTION("one operation, EIO") { check_fault(EIO, From::kOne); }
  SECTION("all from there on, ESTALE") { check_fault(ESTALE, From::kAllFromThere); }
}

TEST_CASE("PassPartsAndJoin_ShortAndInterruptedTransfers_ChangeNoRecord", "[threads]") {
  const PlannedPasses planned;
  make_parts(planned.plan);
  std::string expected;
  {
    const PlannedPasses other;
    make_parts(other.plan);
    REQUIRE(join(other.plan, other.on.sharded()).has_store);
    expected = digest_of(other.on.sharded());
  }
  for (std::uint32_t part = 0; part < kShards; ++part) planned.forget(part);
  {
    const ShortAndInterrupted hook(100);
    make_parts(planned.plan);
    REQUIRE(join(planned.plan, planned.on.sharded(), {.verify = true}).has_store);
    CHECK(hook.operations() > 500);
  }
  CHECK(digest_of(planned.on.sharded()) == expected);
}

TEST_CASE("PassPart_FilesOfTheCommitNotVisibleYet_FailsAndEndsWellLater") {
  const PlannedPasses planned;
  for (const char* const name :
       {"manifest", "version.1", "version.1.shard0", "attribute0.levels.1.shard0", "base.mesh",
        "attribute0.base.1", "plan"}) {
    CAPTURE(name);
    {
      const NotVisibleYet hook({name});
      const Error error = error_of([&] { planned.make(1); });
      INFO(error.what());
      CHECK((error.code() == ErrorCode::kNotFound || error.code() == ErrorCode::kCorruption ||
             error.code() == ErrorCode::kIo));
      CHECK_THAT(error.what(), Catch::Contains(name));
    }
    CHECK_FALSE(std::filesystem::exists(planned.plan / "done.1"));
    CHECK(planned.directories_of(1) == 0);
  }
  make_parts(planned.plan);
  CHECK(join(planned.plan, planned.on.sharded()).has_store);
}

TEST_CASE("PassPart_ManifestOfTheVersionBeforeStillVisible_IsRefused") {
  const PlannedPasses planned;
  const std::filesystem::path manifest = planned.on.sharded() / "manifest";
  const std::string old = content_of(manifest);
  make_parts(planned.plan);
  REQUIRE(join(planned.plan, planned.on.sharded()).has_store);
  const std::filesystem::path next = planned.on.plan(kSmooth, "next");
  const std::string now = content_of(manifest);
  std::ofstream(manifest, std::ios::binary) << old;
  const Error error = error_of([&] { make_part(next, 1, {}, default_backends()); });
  INFO(error.what());
  CHECK((error.code() == ErrorCode::kBadState || error.code() == ErrorCode::kNotFound));
  CHECK_FALSE(std::filesystem::exists(next / "done.1"));
  std::ofstream(manifest, std::ios::binary) << now;
  make_parts(next);
  CHECK(join(next, planned.on.sharded()).has_store);
}

TEST_CASE("PassJoin_PartsNotVisibleYet_AreNamedAndJoinedLater") {
  const PlannedPasses planned;
  make_parts(planned.plan);
  const auto joined_without = [&](const std::set<std::string>& names) {
    const NotVisibleYet hook(names);
    return join(planned.plan, planned.on.sharded());
  };
  CHECK(joined_without({"done.2"}).missing == std::vector<std::uint32_t>{2});
  CHECK(joined_without({"attribute1.levels.2.shard1"}).bad == std::vector<std::uint32_t>{1});
  CHECK(joined_without({"version.2.shard0", "done.1"}).again() == "0-1");
  CHECK(joined_without({"records"}).bad == std::vector<std::uint32_t>{0, 1, 2});
  CHECK(digest_of(planned.on.sharded()) == planned.before);
  CHECK(join(planned.plan, planned.on.sharded()).has_store);
}

}  // namespace plait::test::passes
