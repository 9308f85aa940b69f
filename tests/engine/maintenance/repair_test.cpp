// repair() as a library: nothing is put back without proof, and nothing half-made is left when it
// is cancelled.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>

#include "engine/store/forge.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/manifest.h"
#include "io/file_operations.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/counting_backend.h"
#include "support/error_of.h"
#include "support/killing_operations.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

namespace fs = std::filesystem;

/// The built-in backends, with a codec in `compressed` that writes otherwise than it did before, as
/// a newer release of zstd may.
BackendRegistry with_another_codec() {
  BackendRegistry result;
  for (const std::string& name : default_backends().names()) {
    RegisteredBackend entry = default_backends().find(name);
    if (name == "compressed")
      entry.open = wrapped_volume(entry.open, [](Volume& inner, const LevelSpec& spec) {
        LevelSpec other = spec;
        other.pipeline = "shuffle,zstd:15";
        return inner.open_level(other);
      });
    result.add(std::move(entry));
  }
  return result;
}

/// A disk with a bad place under some blocks of one level, which heals when they are written.
class BadPlace final : public ForwardingBackend {
 public:
  BadPlace(std::unique_ptr<Backend> disk, std::set<std::uint64_t>& bad)
      : ForwardingBackend(std::move(disk)), bad_(bad) {}
  void read(BlockRange blocks, std::span<std::byte> into) override {
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block)
      if (bad_.contains(block)) throw system_error("read", "a bad place", EIO);
    inner().read(blocks, into);
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block)
      bad_.erase(block);
    inner().write(blocks, from);
  }

 private:
  std::set<std::uint64_t>& bad_;
};

/// The built-in backends, with `bad` blocks in level 3 of attribute number 0.
BackendRegistry on_a_bad_disk(std::set<std::uint64_t>& bad) {
  BackendRegistry result;
  for (const std::string& name : default_backends().names()) {
    RegisteredBackend entry = default_backends().find(name);
    entry.open = wrapped_volume(entry.open, [&bad](Volume& disk, const LevelSpec& spec) {
      auto level = disk.open_level(spec);
      if (spec.name != "attribute0.level03.1" || spec.mode == OpenMode::kCreate) return level;
      return std::unique_ptr<Backend>(std::make_unique<BadPlace>(std::move(level), bad));
    });
    result.add(std::move(entry));
  }
  return result;
}

/// A disk that loses what is written to the change log.
class LostWrites final : public FileOperationHook {
 public:
  LostWrites() { set_file_operation_hook(this); }
  ~LostWrites() { set_file_operation_hook(nullptr); }
  LostWrites(const LostWrites&) = delete;
  LostWrites& operator=(const LostWrites&) = delete;
  Verdict before(const FileOperation&) noexcept override { return {}; }
  void after(const FileOperation& operation) noexcept override {
    if (operation.kind != FileOperation::Kind::kWrite ||
        operation.path.filename().native() != "changes.2" || operation.offset != 0)
      return;
    std::fstream file(operation.path, std::ios::in | std::ios::out | std::ios::binary);
    file.write(std::string(operation.bytes, '\0').data(),
               static_cast<std::streamsize>(operation.bytes));
    lost += operation.bytes;
  }
  std::atomic<std::uint64_t> lost = 0;
};

/// A refined store on disk, and what it held.
class Victim {
 public:
  explicit Victim(const std::string& backend) {
    const StoreOptions options{.backend = backend,
                               .durability = Durability::kNone,
                               .block_bytes = 4096,
                               .budget_bytes = 8 << 20};
    Store store =
        Store::create(path(), BaseMesh::build(random_sphere(11, 300)), options, default_backends());
    add_base_positions(store);
    subdivide(store, {.executor = ExecutorKind::kFused, .levels = 3, .normals = true});
    store.commit();
    expected_ = digest(store);
  }

  fs::path path() const { return directory_.path() / "s.plait"; }
  Store open(bool writable = false) const {
    return Store::open(path(), {.writable = writable, .budget_bytes = 8 << 20}, default_backends());
  }
  /// Flips a bit of the block's stored bytes.
  void damage(AttributeId attribute, int level, std::uint64_t block) const {
    const Store store = open();
    const LevelFile& level_file = StoreAccess::level_file(store, attribute, level);
    File file(level_file.path, OpenMode::kReadWrite);
    std::byte value{};
    const std::uint64_t offset = level_file.table[block].offset + 20;
    file.read_at(offset, std::span(&value, 1));
    value ^= std::byte{0x10};
    file.write_at(offset, std::span(&value, 1));
  }
  std::uint64_t damaged_count() const {
    Store store = open();
    return verify(store).damaged_count;
  }
  bool is_as_before() const {
    Store store = open();
    return digest(store) == expected_;
  }
  /// Neither a scratch directory nor anything else beside the store or in it.
  bool is_alone() const {
    return std::distance(fs::directory_iterator(directory_.path()), {}) == 1 && !has_scratch();
  }
  bool has_scratch() const {
    return std::ranges::any_of(fs::directory_iterator(path()),
                               [](const auto& entry) { return entry.is_directory(); });
  }

 private:
  TemporaryDirectory directory_{Medium::kMemory};
  Digest expected_;
};

/// Refuses every change outside the store, as a parent directory of another owner does.
class NothingBeside final : public FileOperationHook {
 public:
  explicit NothingBeside(const fs::path& store) : inside_(store.native() + "/") {
    set_file_operation_hook(this);
  }
  ~NothingBeside() { set_file_operation_hook(nullptr); }
  NothingBeside(const NothingBeside&) = delete;
  NothingBeside& operator=(const NothingBeside&) = delete;
  Verdict before(const FileOperation& operation) noexcept override {
    const bool allowed = is_harmless(operation.kind) ||
                         operation.kind == FileOperation::Kind::kSyncDirectory ||
                         (operation.path / "").native().starts_with(inside_);
    return {.error = allowed ? 0 : EACCES};
  }
  void after(const FileOperation&) noexcept override {}

 private:
  std::string inside_;
};

bool is_raw(const Victim& victim, int level, std::uint64_t block) {
  return StoreAccess::level_file(victim.open(), 0, level).table[block].encoding ==
         BlockEncoding::kRaw;
}

}  // namespace

TEST_CASE("Repair_BlocksThatAnotherCodecWrote_AreLostAndNotOverwritten") {
  const Victim victim("compressed");
  for (std::uint64_t block = 0; block < StoreAccess::level_file(victim.open(), 0, 3).table.size();
       ++block)
    victim.damage(0, 3, block);
  const std::uint64_t damaged = victim.damaged_count();
  const RepairReport report = repair(victim.path(), {}, with_another_codec());
  CHECK(report.lost_count > 0);  // some blocks are the same with either codec
  CHECK(report.lost_count + report.rebuilt_count == damaged);
  CHECK(victim.damaged_count() == report.lost_count);
  CHECK(repair(victim.path(), {}, default_backends()).whole());
  CHECK(victim.is_as_before());
}

TEST_CASE("Repair_Cancelled_LeavesNothingHalfMade") {
  for (const char* backend : {"pread", "mmap", "compressed"}) {
    const Victim victim(backend);
    for (const std::uint64_t block : {0u, 2u, 5u}) victim.damage(0, 3, block);
    fs::remove(victim.path() / "attribute1.level03.1");
    RepairOptions options{.budget_bytes = 704 << 10};
    std::uint64_t calls = 0, last_call = 0;
    options.progress = [&](const Progress&) { return ++calls != last_call; };
    for (last_call = 1; last_call < 1000000; last_call = last_call * 5 / 4 + 1) {
      CAPTURE(backend, last_call);
      calls = 0;
      try {
        const RepairReport report = repair(victim.path(), options, default_backends());
        CHECK(report.whole());
        break;
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kCancelled);
      }
      CHECK(calls == last_call);
      CHECK(victim.is_alone());
    }
    CHECK(last_call > 20);
    CHECK(victim.is_as_before());
    CHECK(victim.is_alone());
  }
}

TEST_CASE("Repair_WhereNothingBesideTheStoreCanBeMade_RepairsIt") {
  const Victim victim("pread");
  victim.damage(0, 3, 2);
  fs::remove(victim.path() / "attribute1.level03.1");
  {
    const NothingBeside refused(victim.path());
    RepairOptions options;
    for (options.dry_run = true;; options.dry_run = false) {
      const RepairReport report = repair(victim.path(), options, default_backends());
      CHECK(report.whole());
      CHECK(report.rebuilt_count == 1);
      CHECK(report.rebuilt_files.size() == 1);
      if (!options.dry_run) break;
    }
  }
  CHECK(victim.is_as_before());
  CHECK(victim.is_alone());
}

TEST_CASE("Repair_Killed_DisturbsNoReaderAndTheNextWriterRemovesWhatItLeft") {
  std::uint64_t last = 0, left_count = 0;
  for (bool killed = true; killed; last = last * 9 / 8 + 1) {
    const Victim victim("compressed");
    victim.damage(0, 3, 2);
    fs::remove(victim.path() / "lock");
    killed = run_and_kill_before(
        last, [&] { static_cast<void>(repair(victim.path(), {}, default_backends())); });
    CAPTURE(last);
    left_count += victim.has_scratch();
    CHECK(victim.damaged_count() <= 1);
    CHECK(check_store(victim.path(), default_backends()).damaged.empty());
    if (left_count % 2 == 0) {
      victim.open(true).close();
      CHECK(victim.is_alone());
    }
    const RepairReport report = repair(victim.path(), {}, default_backends());
    CHECK(report.whole());
    CHECK(report.left_over.empty());
    CHECK(victim.is_alone());
    CHECK(victim.is_as_before());
  }
  CHECK(left_count >= 2);  // both ways of removing it
}

TEST_CASE("Repair_BlocksThatTheDiskDoesNotRead_AreRebuilt") {
  const Victim victim("pread");
  std::set<std::uint64_t> bad = {1, 6};
  const BackendRegistry backends = on_a_bad_disk(bad);
  {
    Store store =
        Store::open(victim.path(), {.writable = false, .budget_bytes = 8 << 20}, backends);
    const VerifyReport report = verify(store);
    REQUIRE(report.damaged_count == 2);
    CHECK(report.damaged[1].block == 6);
    CHECK(report.damaged[1].reason.find("a bad place") != std::string::npos);
  }
  const RepairReport report = repair(victim.path(), {}, backends);
  CHECK(report.whole());
  CHECK(report.rebuilt_count == 2);
  CHECK(victim.is_as_before());
}

TEST_CASE("Repair_OfBlocksThatTheDiskLoses_IsAnErrorAndNotRebuilt") {
  const Victim victim("pread");
  victim.damage(0, 3, 2);
  {
    const LostWrites lost;
    CHECK(error_of([&] { repair(victim.path(), {}, default_backends()); }).code() ==
          ErrorCode::kCorruption);
    CHECK(lost.lost > 0);
  }
  CHECK(victim.damaged_count() == 1);
}

/// One byte changed in place, where the codec writes as many bytes as before: the seals differ, the
/// sizes do not.
TEST_CASE("Repair_BlockChangedInPlaceToTheSameEncodedSize_IsLost") {
  const Victim victim("compressed");
  std::uint64_t changed = 0;
  bool found = false;
  for (; !found && changed < StoreAccess::level_file(victim.open(), 0, 3).table.size(); ++changed) {
    if (is_raw(victim, 3, changed)) continue;
    Store store = victim.open(true);
    LevelFile& file = StoreAccess::level_file(store, 0, 3);
    const std::uint32_t before = file.table[changed].stored_bytes;
    for (std::size_t at = 0; !found && at < 64; ++at) {
      const auto flip = [&] {
        {
          const PinnedBlock pinned =
              StoreAccess::open_session(store).pin(file, changed, Access::kUpdate);
          pinned.bytes()[at] ^= std::byte{1};
        }
        StoreAccess::pager(store).flush();
      };
      flip();
      found = file.table[changed].encoding == BlockEncoding::kEncoded &&
              file.table[changed].stored_bytes == before;
      if (!found) flip();
    }
    store.commit();
    if (found) break;
  }
  REQUIRE(found);
  victim.damage(0, 3, changed);
  const RepairReport report = repair(victim.path(), {}, default_backends());
  CHECK(report.lost_count == 1);
  CHECK(report.rebuilt_count == 0);
}

TEST_CASE("Repair_LevelWhoseTableWantsAnEnormousFile_IsLostAndTakesNoSpace") {
  const Victim victim("compressed");
  {
    std::vector<std::byte> bytes = whole_file(version_file(victim.path()));
    // Of the first block of level 1.
    save(std::span(bytes), tables_offset(bytes), std::uint64_t{1} << 40);
    forge_version_file(victim.path(), bytes);
  }
  for (const bool dry_run : {true, false}) {
    const RepairReport report = repair(victim.path(), {.dry_run = dry_run}, default_backends());
    CHECK(report.rebuilt_files.empty());
    REQUIRE(report.lost_files.size() == 1);
    CHECK(report.lost_files[0].name == "attribute0.level01.1");
    CHECK(report.lost_files[0].reason.find("bytes, expected at most") != std::string::npos);
  }
  CHECK(victim.is_alone());
}

/// Two blocks in one place: whatever is written there, the backend refuses the level.
TEST_CASE("Repair_LevelThatCannotBeReadAfterwards_IsLost") {
  const Victim victim("compressed");
  {
    const Store store = victim.open();
    const LevelFile& file = StoreAccess::level_file(store, 0, 3);
    REQUIRE(file.table.size() > 2);
    std::vector<std::byte> bytes = whole_file(version_file(victim.path()));
    const std::size_t first =
        tables_offset(bytes) + 24 * (StoreAccess::level_file(store, 0, 1).table.size() +
                                     StoreAccess::level_file(store, 0, 2).table.size());
    save(std::span(bytes), first + 24, load<std::uint64_t>(bytes, first));
    forge_version_file(victim.path(), bytes);
  }
  const RepairReport report = repair(victim.path(), {}, default_backends());
  CHECK_FALSE(report.whole());
  CHECK(report.rebuilt_files.empty());
  CHECK(report.lost_files.size() == 1);
}

TEST_CASE("Repair_BlocksWhileAReaderHasTheStore_AreRebuiltInANewVersion") {
  const Victim victim("pread");
  victim.damage(0, 3, 1);
  const Store reader = victim.open();
  CHECK(repair(victim.path(), {}, default_backends()).rebuilt_count == 1);
  CHECK(victim.damaged_count() == 0);
}

TEST_CASE("Repair_StoreThatAWriterHas_IsRefused") {
  const Victim victim("pread");
  victim.damage(0, 3, 1);
  const OpenOptions open{.writable = true};
  const Store writer = Store::open(victim.path(), open, default_backends());
  try {
    repair(victim.path(), {}, default_backends());
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBusy);
  }
  CHECK(repair(victim.path(), {.dry_run = true}, default_backends()).rebuilt_count == 1);
  CHECK(victim.damaged_count() == 1);
}
