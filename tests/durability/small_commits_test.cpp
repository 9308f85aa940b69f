// Thousands of commits that change few blocks: what they write, how much disk they take, and that
// processes killed at random instants between them lose nothing.
//
// PLAIT_LONG=1 in the environment makes 10,000 commits on each backend, and kills 1,000 times on
// all of them together.
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "durability/faults.h"
#include "engine/store/sample_store.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/computing.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::small_commits_test {
namespace {

namespace fs = std::filesystem;

constexpr int kLevel = 5;
constexpr double kMostDisk = 1.6;  ///< of the levels

std::uint64_t commits() { return std::getenv("PLAIT_LONG") ? 10'000 : 150; }
int kills() { return std::getenv("PLAIT_LONG") ? 340 : 12; }

std::vector<std::string> backends_with_generations() {
  std::vector<std::string> names = durable_backends();
  std::erase_if(names, [](const std::string& name) {
    return !default_backends().find(name).traits.overwrites_in_place;
  });
  return names;
}

/// The blocks that version `version` changes: one or a few, and now and then many.
std::vector<std::uint64_t> changed_blocks(std::uint64_t version, std::uint64_t count) {
  std::mt19937_64 random(version);
  const std::uint64_t most = random() % 50 == 0 ? count : 3;
  std::vector<std::uint64_t> blocks(1 + random() % most);
  for (std::uint64_t& block : blocks) block = random() % count;
  std::ranges::sort(blocks);
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

LevelFile& level_of(Store& store) { return StoreAccess::level_file(store, 0, kLevel); }

void make_store(const fs::path& path, const std::string& backend) {
  StoreOptions options = sample_options(backend);
  options.budget_bytes = 128 << 10;
  Store store =
      Store::create(path, BaseMesh::build(torus_grid(12, 8)), options, default_backends());
  store.add_attribute({"value", ComponentType::kUint32, 2}, kLevel);
  for (int level = 1; level <= kLevel; ++level)
    write_level(store, 0, level,
                std::vector<std::byte>(
                    StoreAccess::level_file(store, 0, level).geometry.total_bytes(), std::byte{0}));
  store.commit();
}

/// Every number of a block is the version that changed the block last.
void make_version(Store& store) {
  const auto version = static_cast<std::uint32_t>(store.sequence() + 1);
  LevelFile& level = level_of(store);
  Session session = StoreAccess::open_session(store);
  for (const std::uint64_t block : changed_blocks(version, level.geometry.block_count())) {
    const PinnedBlock pinned = session.pin(level, block, Access::kOverwrite);
    const std::span bytes = pinned.bytes();
    for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) std::memcpy(&bytes[at], &version, 4);
  }
  store.commit();
}

bool holds_its_version(Store& store) {
  const LevelGeometry& geometry = level_of(store).geometry;
  std::vector<std::uint32_t> expected(geometry.block_count());
  for (std::uint64_t version = 2; version <= store.sequence(); ++version)
    for (const std::uint64_t block : changed_blocks(version, expected.size()))
      expected[block] = static_cast<std::uint32_t>(version);
  const std::vector<std::byte> found = read_level(store, 0, kLevel);
  for (std::uint64_t block = 0; block < expected.size(); ++block)
    for (std::uint64_t at = 0; at + 4 <= geometry.block_bytes(block); at += 4)
      if (std::memcmp(&found[geometry.block_offset(block) + at], &expected[block], 4) != 0)
        return false;
  return true;
}

/// Disk space of the levels' files and the change log, as a multiple of the levels' bytes.
double disk_of_levels(const fs::path& path, Store& store) {
  std::uint64_t bytes = 0, levels = 0;
  for (const std::string& name : file_names(path))
    if (struct stat status{};
        (name.starts_with("attribute0.level") || name.starts_with("changes.")) &&
        ::stat((path / name).c_str(), &status) == 0)
      bytes += 512 * static_cast<std::uint64_t>(status.st_blocks);
  for (int level = 1; level <= kLevel; ++level)
    levels += StoreAccess::level_file(store, 0, level).geometry.total_bytes();
  return static_cast<double>(bytes) / static_cast<double>(levels);
}

/// Counts what is written to level files and the change log, and lets no sync reach the disk.
class CountedWrites final : public FileOperationHook {
 public:
  CountedWrites() { set_file_operation_hook(this); }
  ~CountedWrites() { set_file_operation_hook(nullptr); }
  CountedWrites(const CountedWrites&) = delete;
  CountedWrites& operator=(const CountedWrites&) = delete;
  Verdict before(const FileOperation& operation) noexcept override {
    return without_waiting(operation);
  }
  void after(const FileOperation& operation) noexcept override {
    if (operation.kind == FileOperation::Kind::kWrite &&
        (operation.path.native().find(".level") != std::string::npos ||
         operation.path.native().find("changes.") != std::string::npos))
      bytes += operation.bytes;
    using Kind = FileOperation::Kind;
    if (operation.kind == Kind::kSync || operation.kind == Kind::kSyncDirectory) ++syncs;
    if (operation.kind == Kind::kCreate) ++files;
  }
  std::atomic<std::uint64_t> bytes = 0;
  std::atomic<int> syncs = 0, files = 0;
};

/// Commits versions in a process of its own. Kills it when it has computed for `lifetime`;
/// `after_a_commit`: which begins when the process has committed once, however long a busy machine
/// takes for that.
void commit_until_killed(const fs::path& path, std::chrono::microseconds lifetime, bool waits,
                         bool after_a_commit) {
  std::array<int, 2> pipe{};
  REQUIRE(::pipe(pipe.data()) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    try {
      std::optional<NoWaiting> no_waiting;
      if (!waits) no_waiting.emplace();
      Store store =
          Store::open(path, {.writable = true, .budget_bytes = 128 << 10}, default_backends());
      make_version(store);
      if (::write(pipe[1], "", 1) != 1) ::_exit(2);
      while (true) make_version(store);
    } catch (...) {
      ::_exit(3);
    }
  }
  ::close(pipe[1]);
  if (char byte = 0; after_a_commit) CHECK(::read(pipe[0], &byte, 1) == 1);
  computes_for(child, lifetime);
  ::kill(child, SIGKILL);
  ::close(pipe[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK(WIFSIGNALED(status));
}

}  // namespace

TEST_CASE("SmallCommits_OneBlockInAHundred_WriteLittleMoreThanTheseBlocks") {
  for (const std::string& backend : backends_with_generations()) {
    CAPTURE(backend);
    const TemporaryDirectory here;
    make_store(here.path() / "s.plait", backend);
    Store store = Store::open(here.path() / "s.plait", {true}, default_backends());
    LevelFile& level = level_of(store);
    REQUIRE(level.geometry.block_count() >= 100);
    const std::uint64_t count = level.geometry.block_count() / 100;
    const CountedWrites written;
    for (std::uint64_t block = 0; block < count; ++block)
      std::ranges::fill(
          StoreAccess::open_session(store).pin(level, block * 100, Access::kOverwrite).bytes(),
          std::byte{7});
    store.commit();
    CHECK(written.bytes >= count * level.geometry.max_block_bytes());
    CHECK(static_cast<double>(written.bytes) <=
          1.2 * static_cast<double>(count * level.geometry.max_block_bytes()));
  }
}

TEST_CASE("SmallCommits_BlocksOfAllLevelsAndBaseRecords_TakeTwoSyncsAndNoNewFile") {
  for (const std::string& backend : backends_with_generations()) {
    CAPTURE(backend);
    const TemporaryDirectory here;
    make_store(here.path() / "s.plait", backend);
    std::vector<std::byte> expected;
    {
      Store store = Store::open(here.path() / "s.plait", {true}, default_backends());
      for (int commit = 1; commit <= 3; ++commit) {
        const CountedWrites counted;
        for (int level = 1; level <= kLevel; ++level)
          std::ranges::fill(
              StoreAccess::open_session(store)
                  .pin(StoreAccess::level_file(store, 0, level), 0, Access::kOverwrite)
                  .bytes(),
              static_cast<std::byte>(commit));
        store.base_bytes(0)[5] = static_cast<std::byte>(commit);
        store.commit();
        CHECK(store.sequence() == static_cast<std::uint64_t>(1 + commit));
        // The first one begins the log.
        CHECK((counted.syncs == 2) == (commit > 1));
        CHECK((counted.files == 0) == (commit > 1));
      }
      expected.assign(std::as_const(store).base_bytes(0).begin(),
                      std::as_const(store).base_bytes(0).end());
    }
    for (const bool writable : {false, true}) {
      Store store = Store::open(here.path() / "s.plait", {writable}, default_backends());
      CHECK(store.sequence() == 4);
      CHECK(std::ranges::equal(std::as_const(store).base_bytes(0), expected));
      CHECK(expected[5] == std::byte{3});
      for (int level = 1; level <= kLevel; ++level)
        CHECK(read_level(store, 0, level)[0] == std::byte{3});
      CHECK(verify(store).damaged_count == 0);
      const std::uint64_t before = store.sequence();
      if (writable) store.commit();  // nothing has changed
      CHECK(store.sequence() == before);
    }
    CHECK(check_store(here.path() / "s.plait", default_backends()).left_over.empty());
  }
}

TEST_CASE("SmallCommits_Thousands_TakeABoundedDiskAndKeepTheirBytes") {
  for (const std::string& backend : backends_with_generations()) {
    CAPTURE(backend);
    const NoWaiting no_waiting;
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    make_store(path, backend);
    std::optional<Store> store =
        Store::open(path, {.writable = true, .budget_bytes = 128 << 10}, default_backends());
    double most = 0;
    for (std::uint64_t commit = 1; commit <= commits(); ++commit) {
      make_version(*store);
      most = std::max(most, disk_of_levels(path, *store));
      if (commit % 50 != 0) continue;
      CHECK(holds_its_version(*store));
      store.reset();
      store = Store::open(path, {.writable = true, .budget_bytes = 128 << 10}, default_backends());
      CHECK(holds_its_version(*store));
    }
    CHECK(verify(*store).damaged_count == 0);
    CHECK(most <= kMostDisk);
    CHECK(most > 1.05);  // it had a change log
    CHECK(check_store(path, default_backends()).damaged.empty());
  }
}

TEST_CASE("SmallCommits_KilledAtAnyInstant_LoseNothingAndLeaveNothing") {
  std::mt19937_64 random(11);
  for (const std::string& backend : backends_with_generations()) {
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    make_store(path, backend);
    std::uint64_t version = 1;
    for (int kill = 0; kill < kills(); ++kill) {
      CAPTURE(backend, kill, version);
      commit_until_killed(path, std::chrono::microseconds(random() % 20'000), kill % 4 == 0,
                          kill % 2 == 1);
      {
        Store reader = Store::open(path, {}, default_backends());
        CHECK(reader.sequence() >= version);
        CHECK(holds_its_version(reader));
        version = reader.sequence();
      }
      const NoWaiting no_waiting;
      Store writer =
          Store::open(path, {.writable = true, .budget_bytes = 128 << 10}, default_backends());
      CHECK(writer.sequence() == version);
      CHECK(holds_its_version(writer));
      CHECK(disk_of_levels(path, writer) <= kMostDisk);
      CHECK(check_store(path, default_backends()).left_over.empty());
    }
    CHECK(version > 1);
  }
}

TEST_CASE("SmallCommits_WithoutDurability_KeepTheLastCommit") {
  for (const std::string& backend : backends_with_generations()) {
    CAPTURE(backend);
    const TemporaryDirectory here;
    const fs::path path = here.path() / "s.plait";
    make_store(path, backend);
    OpenOptions options{.writable = true, .budget_bytes = 128 << 10};
    options.durability = Durability::kNone;
    Store store = Store::open(path, options, default_backends());
    for (int commit = 0; commit < 20; ++commit) make_version(store);
    // Changes that are not committed.
    std::ranges::fill(
        StoreAccess::open_session(store).pin(level_of(store), 0, Access::kOverwrite).bytes(),
        std::byte{0xee});
    StoreAccess::pager(store).flush();
    store.close();
    Store reader = Store::open(path, {}, default_backends());
    CHECK(reader.sequence() == 21);
    CHECK(holds_its_version(reader));
  }
}

}  // namespace plait::test::small_commits_test
