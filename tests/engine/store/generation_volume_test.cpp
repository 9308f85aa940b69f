// GenerationVolume around "pread": which of a level's files has a block, and which files a version
// has (store/generation_fold.cpp).
#include "store/generation_volume.h"

#include <catch2/catch.hpp>
#include <set>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "format/file_names.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBlockBytes = 4096, kBlocks = 20;
using Generations = std::vector<Generation>;

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
    table.set_generations({{1, 0}});
    level = volume.open_level(spec(OpenMode::kCreate));
    level->write({0, kBlocks}, std::vector<std::byte>(kBlocks * kBlockBytes, std::byte{1}));
    commit();
  }
  LevelSpec spec(OpenMode mode) {
    return {directory, level_file_name(0, 1, table.generations().front().version), mode, geometry,
            table};
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
    volume.begin_version(++version, held);
    CHECK(values(*level) == expected);
    // As another process reads it.
    Notes others;
    GenerationVolume reading(std::make_unique<NotingVolume>(others), directory, version, {});
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
  Generations generations() const {
    return {table.generations().begin(), table.generations().end()};
  }
  std::vector<std::byte> whole_file() const {
    return file_bytes(place.path() / "attribute0.level01.1");
  }

  TemporaryDirectory place;
  Directory directory{place.path()};
  LevelGeometry geometry{SlotShapes(kBlocks * kBlockBytes), BaseRelativeLevel(1), 1, kBlockBytes};
  BlockTable table{{}, 0, 1, kBlocks};
  Notes notes;
  std::uint64_t version = 0;
  std::vector<int> expected = std::vector<int>(kBlocks, 1);
  GenerationVolume volume{std::make_unique<NotingVolume>(notes), directory, 0, {}};
  std::unique_ptr<Backend> level;
};

}  // namespace

TEST_CASE("GenerationLevel_BlockWrittenAnew_IsReadFromTheNewFileAndOthersFromTheOld") {
  const bool by_transfer = GENERATE(false, true);
  Fixture f;
  const std::vector<std::byte> before = f.whole_file();
  CHECK(file_names(f.place.path()) == std::set<std::string>{"attribute0.level01.1"});
  f.put(2, 7, by_transfer);
  f.put(0, 8, by_transfer);
  CHECK(file_names(f.place.path()) ==
        std::set<std::string>{"attribute0.level01.1", "attribute0.level01.2"});
  CHECK(f.values(*f.level) == f.expected);
  CHECK(f.expected[2] == 7);
  CHECK(f.whole_file() == before);
}

TEST_CASE("GenerationLevel_WriteToTheNewFileThatFails_LeavesTheBlockAsItWas") {
  Fixture f;
  f.notes.fail_writes = true;
  CHECK(f.put(2, 7, true));
  CHECK(error_of([&] { f.put(3, 7); }).code() == ErrorCode::kNoSpace);
  CHECK(f.values(*f.level) == std::vector<int>(kBlocks, 1));
}

TEST_CASE("GenerationFold_FewBlocks_StayInASparseFileEach") {
  Fixture f;
  f.commit_blocks(3, 2);
  CHECK(f.generations() == Generations{{1, 0}, {2, 2}});
  CHECK(f.table[3].file == 1);
  CHECK(f.table[5].file == 0);
  f.commit_blocks(4, 2);  // block 4 again: the file of version 2 still has block 3
  CHECK(f.generations() == Generations{{1, 0}, {2, 2}, {3, 2}});
  f.commit_blocks(3, 1);  // no block is left there
  CHECK(f.generations() == Generations{{1, 0}, {3, 2}, {4, 1}});
  CHECK(f.table[3].file == 2);
  CHECK(f.table[4].file == 1);
}

TEST_CASE("GenerationFold_HalfOfTheBlocksInOneVersion_MakeTheNewFileTheLevel") {
  Fixture f;
  f.commit_blocks(0, 3);
  f.commit_blocks(2, kBlocks / 2);
  CHECK(f.generations() == Generations{{3, 0}});
  for (const BlockEntry& entry : f.table.entries()) CHECK(entry.file == 0);
}

TEST_CASE("GenerationFold_PassThatWasToWriteAllBlocksAndWroteOne_MakesTheNewFileTheLevel") {
  Fixture f;
  f.level->advise({0, kBlocks}, Advice::kOverwrite);
  f.commit_blocks(5, 1);
  CHECK(f.generations() == Generations{{2, 0}});
  f.commit_blocks(6, 1);  // the advice was for one version
  CHECK(f.generations() == Generations{{2, 0}, {3, 1}});
}

TEST_CASE("GenerationFold_HalfOfTheBlocksInSparseFiles_GoBackToTheWholeFile") {
  Fixture f;
  f.commit_blocks(0, 4);
  f.commit_blocks(4, 4);
  f.commit_blocks(7, 3);  // 11 blocks in all; block 7 is in the second file and the third
  CHECK(f.generations() == Generations{{1, 0}, {4, 3}});
  CHECK(f.table[0].file == 0);
  CHECK(f.table[7].file == 1);
  f.commit_blocks(0, 1);  // goes on from there
  CHECK(f.generations() == Generations{{1, 0}, {4, 3}, {5, 1}});
}

TEST_CASE("GenerationFold_WhileReadersHaveOlderVersions_LeavesTheWholeFileAsItIs") {
  Fixture f;
  f.commit_blocks(0, 4, {1});
  f.commit_blocks(4, 4, {1});
  const std::vector<std::byte> before = f.whole_file();
  f.commit_blocks(12, 1, {1});
  f.commit_blocks(13, 1, {1});  // 10 blocks: now all are together, and half
  CHECK(f.generations() == Generations{{5, 0}});
  CHECK(f.whole_file() == before);
}

TEST_CASE("GenerationFold_MoreFilesThanALevelMayHave_AreTakenTogether") {
  for (const bool is_read : {false, true}) {
    Fixture f;
    const std::vector<std::uint64_t> held =
        is_read ? std::vector<std::uint64_t>{1} : std::vector<std::uint64_t>{};
    for (std::uint64_t block = 0; block < kMostSparseFiles; ++block)
      f.commit_blocks(block, 1, held);
    CHECK(f.generations().size() == kMostSparseFiles + 1);
    f.commit_blocks(kMostSparseFiles, 1, held);
    CHECK(f.generations() ==
          Generations{{1, 0}, {kMostSparseFiles + 2, is_read ? kMostSparseFiles + 1 : 1}});
  }
}

TEST_CASE("GenerationVolume_BeginVersion_TellsTheInnerVolume") {
  Fixture f;
  f.volume.begin_version(7, std::vector<std::uint64_t>{2, 5});
  CHECK(f.notes.versions.back() == std::pair{std::uint64_t{7}, std::vector<std::uint64_t>{2, 5}});
}

}  // namespace plait::test
