// GenerationVolume around a volume that only notes what it is told: which file a block is written
// to and read from.
#include "store/generation_volume.h"

#include <catch2/catch.hpp>
#include <map>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "store/journaled_volume.h"
#include "store/rollback_journal.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBlockBytes = 4096, kBlocks = 4;

/// What an inner volume was told.
struct Notes {
  std::vector<std::string> opened;
  std::vector<std::pair<std::uint64_t, std::vector<std::uint64_t>>> versions;
  bool fail_writes = false;
};

/// Keeps one byte of each block.
class NotingLevel final : public Backend {
 public:
  NotingLevel(const LevelSpec& level, const Notes& notes)
      : geometry_(level.geometry), table_(level.table), notes_(notes) {}
  void read(BlockRange blocks, std::span<std::byte> into) override {
    for (std::uint64_t at = 0; at < blocks.count; ++at)
      std::ranges::fill(into.subspan(at * kBlockBytes, kBlockBytes), values_[blocks.first + at]);
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (notes_.fail_writes) throw Error(ErrorCode::kNoSpace, "noting: full");
    for (std::uint64_t at = 0; at < blocks.count; ++at) {
      const std::uint64_t block = blocks.first + at;
      values_[block] = from[at * kBlockBytes];
      table_.seal(block, geometry_.block_offset(block), BlockEncoding::kRaw,
                  from.subspan(at * kBlockBytes, kBlockBytes));
    }
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return 0; }

 private:
  const LevelGeometry& geometry_;
  BlockTable& table_;
  const Notes& notes_;
  std::map<std::uint64_t, std::byte> values_;
};

class NotingVolume final : public Volume {
 public:
  explicit NotingVolume(Notes& notes) : notes_(notes) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    notes_.opened.push_back(level.name);
    return std::make_unique<NotingLevel>(level, notes_);
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    notes_.versions.emplace_back(sequence, std::vector(held.begin(), held.end()));
  }

 private:
  Notes& notes_;
};

class Ended final : public TransferListener {
 public:
  void finished(Transfer&, std::exception_ptr error) noexcept override { failed = bool(error); }
  bool failed = false;
};

/// A level whose blocks hold 1 in version 1, which is committed.
struct Fixture {
  Fixture() {
    level =
        volume.open_level({directory, "attribute0.level01.1", OpenMode::kCreate, geometry, table});
    level->write({0, kBlocks}, std::vector<std::byte>(kBlocks * kBlockBytes, std::byte{1}));
    volume.begin_version(1, {});
  }
  /// By a transfer, or at once. Whether it failed.
  bool put(std::uint64_t block, std::byte value, bool by_transfer) {
    std::vector<std::byte> bytes(kBlockBytes, value);
    if (!by_transfer) {
      level->write({block, 1}, bytes);
      return false;
    }
    Ended ended;
    Transfer transfer{.direction = Transfer::Direction::kWrite,
                      .block = block,
                      .memory = bytes,
                      .listener = &ended};
    level->start(transfer);
    return ended.failed;
  }
  /// The values of all blocks, as one call reads them.
  std::vector<int> values() {
    std::vector<std::byte> bytes(kBlocks * kBlockBytes);
    level->read({0, kBlocks}, bytes);
    std::vector<int> result;
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      result.push_back(static_cast<int>(bytes[block * kBlockBytes]));
    return result;
  }

  TemporaryDirectory place;
  Directory directory{place.path()};
  LevelGeometry geometry{SlotShapes(kBlocks * kBlockBytes), BaseRelativeLevel(1), 1, kBlockBytes};
  BlockTable table{{}, 0, 1, kBlocks};
  Notes notes;
  GenerationVolume volume{std::make_unique<NotingVolume>(notes), directory, 0};
  std::unique_ptr<Backend> level;
};

}  // namespace

TEST_CASE("GenerationLevel_BlockWrittenAnew_IsReadFromTheNewFileAndOthersFromTheOld") {
  const bool by_transfer = GENERATE(false, true);
  Fixture f;
  CHECK(f.notes.opened == std::vector<std::string>{"attribute0.level01.1"});
  f.put(2, std::byte{7}, by_transfer);
  CHECK(f.notes.opened.back() == "attribute0.level01.2");
  CHECK(f.values() == std::vector{1, 1, 7, 1});
  f.put(0, std::byte{8}, by_transfer);
  CHECK(f.notes.opened.size() == 2);
  CHECK(f.values() == std::vector{8, 1, 7, 1});
}

TEST_CASE("GenerationLevel_WriteToTheNewFileThatFails_LeavesTheBlockAsItWas") {
  Fixture f;
  f.notes.fail_writes = true;
  CHECK(f.put(2, std::byte{7}, true));
  CHECK(error_of([&] { f.put(3, std::byte{7}, false); }).code() == ErrorCode::kNoSpace);
  CHECK(f.values() == std::vector{1, 1, 1, 1});
}

TEST_CASE("GenerationLevel_NewFileLargerThanTheDisk_IsRefusedBeforeItIsMade") {
  Fixture f;
  const LevelGeometry geometry(SlotShapes(64), BaseRelativeLevel(20), 12, kBlockBytes);
  BlockTable table({}, 0, 20, geometry.block_count());
  for (BlockEntry& entry : table.entries()) entry.encoding = BlockEncoding::kRaw;
  const auto level = f.volume.open_level(
      {f.directory, "attribute0.level20.1", OpenMode::kReadWrite, geometry, table});
  const std::vector<std::byte> block(kBlockBytes);  // its beginning: nobody looks at it
  const std::size_t opened = f.notes.opened.size();
  CHECK(error_of([&] { level->write({3, 1}, block); }).code() == ErrorCode::kNoSpace);
  CHECK(f.notes.opened.size() == opened);
}

TEST_CASE("VolumeAroundAnother_BeginVersion_TellsTheOther") {
  const TemporaryDirectory place;
  const Directory directory(place.path());
  const std::vector<std::uint64_t> held{2, 5};
  Notes around, journaled;
  GenerationVolume(std::make_unique<NotingVolume>(around), directory, 6).begin_version(7, held);
  RollbackJournal journal(directory, {}, 6, 4096);
  JournaledVolume(std::make_unique<NotingVolume>(journaled), journal).begin_version(7, held);
  for (const Notes& notes : {around, journaled}) {
    REQUIRE(notes.versions.size() == 1);
    CHECK(notes.versions[0].first == 7);
    CHECK(notes.versions[0].second == held);
  }
}

}  // namespace plait::test
