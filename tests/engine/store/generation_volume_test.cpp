// GenerationVolume around "pread": which file has a block, and which files a version has
// (store/generation_fold.cpp).
#include "store/generation_volume.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "format/file_names.h"
#include "plait/extend/file.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

/// Half of the level has more than 1 MiB, so it can be a new generation; the log has as many bytes.
constexpr std::uint64_t kBlockBytes = 65536, kBlocks = 40;

/// What the tests know of the inner volume.
struct Notes {
  std::vector<std::pair<std::uint64_t, std::vector<std::uint64_t>>> versions;
  bool fail_writes = false;
};

class FailingLevel final : public Backend {
 public:
  FailingLevel(std::unique_ptr<Backend> inner, const Notes& notes)
      : inner_(std::move(inner)), notes_(notes) {}
  void read(BlockRange blocks, std::span<std::byte> into) override { inner_->read(blocks, into); }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (notes_.fail_writes) throw Error(ErrorCode::kNoSpace, "noting: full");
    inner_->write(blocks, from);
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool durable) override { inner_->sync(durable); }
  std::uint64_t stored_bytes() const override { return inner_->stored_bytes(); }

 private:
  std::unique_ptr<Backend> inner_;
  const Notes& notes_;
};

class NotingVolume final : public Volume {
 public:
  explicit NotingVolume(Notes& notes) : notes_(notes) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    return std::make_unique<FailingLevel>(inner_->open_level(level), notes_);
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    notes_.versions.emplace_back(sequence, std::vector(held.begin(), held.end()));
  }

 private:
  std::unique_ptr<Volume> inner_ = default_backends().find("pread").open({});
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
    table.set_generation(1);
    level = volume.open_level(spec(OpenMode::kCreate));
    level->write({0, kBlocks}, std::vector<std::byte>(kBlocks * kBlockBytes, std::byte{1}));
    commit();
  }
  LevelSpec spec(OpenMode mode) {
    return {directory, level_file_name(0, 1, table.generation()), mode, geometry, table};
  }
  /// By a transfer, or at once. Returns whether it failed.
  bool put(std::uint64_t block, int value, bool by_transfer = false) {
    std::vector<std::byte> bytes(kBlockBytes, static_cast<std::byte>(value));
    if (!by_transfer) {
      level->write({block, 1}, bytes);
      expected[block] = value;
      return false;
    }
    Ended ended;
    Transfer transfer{.direction = Transfer::Direction::kWrite,
                      .block = block,
                      .memory = bytes,
                      .listener = &ended};
    level->start(transfer);
    if (!ended.failed) expected[block] = value;
    return ended.failed;
  }
  void commit(const std::vector<std::uint64_t>& held = {}) {
    level->sync(true);
    log = volume.is_small_commit() ? volume.commit_changes(log, {}, {}, true)
                                   : volume.finish_log(true);
    volume.begin_version(++version, held);
    CHECK(values(*level) == expected);
    // As another process reads it.
    Notes others;
    GenerationVolume reading(std::make_unique<NotingVolume>(others), directory, version, log,
                             false);
    CHECK(values(*reading.open_level(spec(OpenMode::kRead))) == expected);
  }
  /// Writes `count` blocks from `first` on, and commits.
  void commit_blocks(std::uint64_t first, std::uint64_t count,
                     const std::vector<std::uint64_t>& held = {}) {
    for (std::uint64_t block = first; block < first + count; ++block)
      put(block, static_cast<int>(version + 1));
    commit(held);
  }
  /// The values of all blocks, as one call reads them.
  static std::vector<int> values(Backend& of) {
    std::vector<std::byte> bytes(kBlocks * kBlockBytes);
    of.read({0, kBlocks}, bytes);
    std::vector<int> result;
    for (std::uint64_t block = 0; block < kBlocks; ++block)
      result.push_back(static_cast<int>(bytes[block * kBlockBytes]));
    return result;
  }
  /// As a reader has the lock of the first version.
  void begin_reader() {
    reader = File(directory, version_file_name(1), OpenMode::kCreate);
    REQUIRE(reader.lock(false));
  }
  std::vector<std::byte> file(const std::string& name) const {
    return file_bytes(place.path() / name);
  }
  std::uint64_t blocks_in_log() const {
    return static_cast<std::uint64_t>(
        std::ranges::count(table.entries(), kLogFile, &BlockEntry::file));
  }

  TemporaryDirectory place;
  Directory directory{place.path()};
  LevelGeometry geometry{SlotShapes(kBlocks * kBlockBytes), BaseRelativeLevel(1), 1, kBlockBytes};
  BlockTable table{{}, 0, 1, kBlocks};
  Notes notes;
  std::uint64_t version = 0;
  LogPlace log;
  std::vector<int> expected = std::vector<int>(kBlocks, 1);
  GenerationVolume volume{std::make_unique<NotingVolume>(notes), directory, 0, {}, true};
  std::unique_ptr<Backend> level;
  File reader;
};

}  // namespace

TEST_CASE("GenerationLevel_BlockWrittenAnew_IsReadFromTheLogAndOthersFromTheFile") {
  const bool by_transfer = GENERATE(false, true);
  Fixture f;
  const std::vector<std::byte> before = f.file("attribute0.level01.1");
  CHECK(file_names(f.place.path()) == std::set<std::string>{"attribute0.level01.1"});
  f.put(2, 7, by_transfer);
  f.put(0, 8, by_transfer);
  CHECK(file_names(f.place.path()) == std::set<std::string>{"attribute0.level01.1", "changes.2"});
  CHECK(f.values(*f.level) == f.expected);
  CHECK(f.expected[2] == 7);
  f.put(2, 9, by_transfer);  // no version has what is there, so it is overwritten
  CHECK(f.values(*f.level) == f.expected);
  f.commit();
  CHECK(f.log.bytes == 2 * kBlockBytes);
  CHECK(f.file("attribute0.level01.1") == before);
}

TEST_CASE("GenerationLevel_WriteToTheNewFileThatFails_LeavesTheBlockAsItWas") {
  Fixture f;
  f.level->advise({0, kBlocks}, Advice::kOverwrite);
  f.notes.fail_writes = true;
  CHECK(f.put(2, 7, true));
  CHECK(error_of([&] { f.put(3, 7); }).code() == ErrorCode::kNoSpace);
  CHECK(f.values(*f.level) == std::vector<int>(kBlocks, 1));
}

TEST_CASE("GenerationFold_FewBlocks_StayInTheLog") {
  Fixture f;
  f.commit_blocks(3, 2);
  CHECK(f.log.generation == 2);
  CHECK(f.log.last_record == 0);  // a version with a file of its own began the log
  CHECK(f.table[3].file == kLogFile);
  CHECK(f.table[5].file == kLevelFile);
  const std::vector<std::byte> before = f.file("changes.2");
  const std::uint64_t end = f.log.bytes;
  f.commit_blocks(4, 2);
  CHECK(f.log.generation == 2);
  CHECK(f.log.last_record >= end);
  CHECK(f.table[4].offset >= end);
  CHECK(f.table[3].offset < end);
  CHECK(f.table.generation() == 1);
  std::vector<std::byte> after = f.file("changes.2");
  after.resize(end);
  CHECK(std::ranges::equal(after, std::span(before).first(end)));
}

TEST_CASE("GenerationFold_HalfOfTheBlocksInOneVersion_MakeANewGeneration") {
  Fixture f;
  f.commit_blocks(0, 3);
  f.commit_blocks(2, kBlocks / 2);
  CHECK(f.table.generation() == 3);
  CHECK(f.blocks_in_log() == 0);
  CHECK(f.log == LogPlace{});
  f.commit_blocks(7, 1);  // goes on from there
  CHECK(f.log.generation == 4);
}

TEST_CASE("GenerationFold_PassThatWasToWriteAllBlocksAndWroteOne_MakesANewGeneration") {
  Fixture f;
  f.level->advise({0, kBlocks}, Advice::kOverwrite);
  f.commit_blocks(5, 1);
  CHECK(f.table.generation() == 2);
  f.commit_blocks(6, 1);  // the advice was for one version
  CHECK(f.table.generation() == 2);
  CHECK(f.blocks_in_log() == 1);
}

TEST_CASE("GenerationFold_FullLogThatNobodyReads_IsPutBackIntoTheLevelsFile") {
  Fixture f;
  for (int commit = 0; commit < 8; ++commit) f.commit_blocks(3, 2);
  CHECK(f.log.last_record != 0);
  f.commit_blocks(8, 2);
  CHECK(f.log.last_record == 0);  // the log is nearly full, so the version has a file of its own
  CHECK(f.log.generation == 2);
  std::vector<std::byte> expected = f.file("attribute0.level01.1");
  f.commit_blocks(9, 2);
  CHECK(f.log == LogPlace{11, 2 * kBlockBytes, 0, 0});
  CHECK(f.table.generation() == 1);
  CHECK(f.blocks_in_log() == 2);
  // A crash may bring the version before back, which has block 10 in the level's file.
  const auto fill = [&](std::uint64_t block, int value) {
    std::ranges::fill(std::span(expected).subspan(block * kBlockBytes, kBlockBytes),
                      static_cast<std::byte>(value));
  };
  fill(3, 9);
  fill(4, 9);
  fill(8, 10);
  CHECK(f.file("attribute0.level01.1") == expected);
  f.commit_blocks(4, 1);
  CHECK(f.log.generation == 11);
}

// The locks do not tell whether a reader has a version of a record before the newest one.
TEST_CASE("GenerationFold_LogThatIsFullAmongRecords_IsNotPutBack") {
  Fixture f;
  for (int commit = 0; commit < 8; ++commit) f.commit_blocks(3, 2);
  CHECK(f.log.last_record != 0);
  const std::vector<std::byte> before = f.file("attribute0.level01.1");
  f.commit_blocks(20, 6);
  CHECK(f.log.generation == 10);
  CHECK(f.blocks_in_log() == 8);
  CHECK(f.file("attribute0.level01.1") == before);
}

TEST_CASE("GenerationFold_LogThatFillsWithinOneCommit_PutsBackOnlyWhatTheVersionBeforeHasThere") {
  Fixture f;
  f.commit_blocks(0, 15);
  CHECK(f.log.last_record == 0);
  const std::vector<std::byte> before = f.file("attribute0.level01.1");
  f.commit_blocks(20, 6);
  CHECK(f.log == LogPlace{3, 6 * kBlockBytes, 0, 0});
  CHECK(f.table.generation() == 1);
  const std::vector<std::byte> after = f.file("attribute0.level01.1");
  CHECK(after[14 * kBlockBytes] == std::byte{2});
  CHECK(std::ranges::equal(std::span(after).subspan(15 * kBlockBytes),
                           std::span(before).subspan(15 * kBlockBytes)));
}

TEST_CASE("GenerationFold_FullLogOfFewBlocksWithAReader_IsCopiedToANewOne") {
  Fixture f;
  f.begin_reader();
  for (int commit = 0; commit < 9; ++commit) f.commit_blocks(3, 2);
  CHECK(f.log.generation == 2);
  const std::vector<std::byte> before = f.file("changes.2");
  f.commit_blocks(5, 1);
  CHECK(f.log == LogPlace{11, 3 * kBlockBytes, 0, 0});
  CHECK(f.blocks_in_log() == 3);
  CHECK(f.table.generation() == 1);
  CHECK(f.file("changes.2") == before);  // readers may need it
  f.commit_blocks(4, 1);
  CHECK(f.log.generation == 11);
}

TEST_CASE("GenerationFold_FullLogOfAQuarterOfTheBlocksWithAReader_MakesANewGeneration") {
  Fixture f;
  f.begin_reader();
  for (std::uint64_t commit = 0; commit < 3; ++commit) f.commit_blocks(commit * 2, 10);
  const std::vector<std::byte> before = f.file("attribute0.level01.1");
  CHECK(f.table.generation() == 3);
  CHECK(f.blocks_in_log() == 10);
  CHECK(f.file("attribute0.level01.1") == before);
}

TEST_CASE("GenerationVolume_RolledBack_HasTheCommittedLog") {
  Fixture f;
  for (int commit = 0; commit < 9; ++commit) f.commit_blocks(3, 2);
  const std::vector<int> expected = f.expected;
  const BlockTable table = f.table;
  for (std::uint64_t block = 0; block < 5; ++block) f.put(block, 77);
  CHECK(file_names(f.place.path()).contains("changes.11"));  // it did not fit into the old one
  f.level.reset();
  f.volume.roll_back();
  f.table = table;
  f.level = f.volume.open_level(f.spec(OpenMode::kReadWrite));
  f.expected = expected;
  CHECK(f.values(*f.level) == expected);
  f.commit_blocks(6, 1);
}

TEST_CASE("GenerationVolume_BeginVersion_TellsTheInnerVolume") {
  Fixture f;
  f.volume.begin_version(7, std::vector<std::uint64_t>{2, 5});
  CHECK(f.notes.versions.back() == std::pair{std::uint64_t{7}, std::vector<std::uint64_t>{2, 5}});
}

}  // namespace plait::test
