// Runs: several adjacent blocks in one call of the operating system (Backend::start_run). The hook
// of file operations counts the calls, cuts them short and lets them fail.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <random>
#include <vector>

#include "backends/conformance.h"
#include "io/file_operations.h"
#include "plait/detail/level_file.h"
#include "plait/error.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

using Way = Transfer::Direction;

/// The process's hook while it exists: counts reads and writes, and answers them.
class CountedCalls final : public FileOperationHook {
 public:
  CountedCalls() { set_file_operation_hook(this); }
  ~CountedCalls() { set_file_operation_hook(nullptr); }
  CountedCalls(const CountedCalls&) = delete;
  CountedCalls& operator=(const CountedCalls&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    if (operation.kind != FileOperation::Kind::kRead &&
        operation.kind != FileOperation::Kind::kWrite)
      return {};
    ++count;
    if (interrupted > 0) {
      --interrupted;
      return {.error = EINTR};
    }
    const std::uint64_t end = operation.offset + std::min(operation.bytes, most_bytes.load());
    if (bad_byte >= operation.offset && bad_byte < end) {
      if (bad_byte / 4096 == operation.offset / 4096) return {.error = EIO};
      // As a disk does, up to the page of the bad byte.
      return {.most_bytes = bad_byte / 4096 * 4096 - operation.offset};
    }
    return {.most_bytes = most_bytes};
  }
  void after(const FileOperation&) noexcept override {}

  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::atomic<std::uint64_t> count = 0, most_bytes = kNone, bad_byte = kNone;
  std::atomic<int> interrupted = 0;
};

/// Memory with the alignment of frames for the blocks of a level, and their transfers.
class MovedRun final : public TransferListener {
 public:
  MovedRun(Backend& backend, const LevelGeometry& geometry, BlockRange blocks) : backend_(backend) {
    const std::uint64_t pages = geometry.max_block_bytes() / 4096 + 1;
    memory_.resize((blocks.count * pages + 1) * 4096);
    void* at = memory_.data();
    std::size_t space = memory_.size();
    auto* next = static_cast<std::byte*>(std::align(4096, 1, at, space));
    transfers_.resize(blocks.count);
    errors_.resize(blocks.count);
    for (std::uint64_t i = 0; i < blocks.count; ++i, next += pages * 4096)
      transfers_[i] = {.block = blocks.first + i,
                       .memory = {next, geometry.block_bytes(blocks.first + i)},
                       .listener = this,
                       .tag = static_cast<std::uint32_t>(i)};
  }

  void move(Way direction) {
    std::ranges::fill(errors_, nullptr);
    pending_ = transfers_.size();
    std::vector<Transfer*> run;
    for (Transfer& transfer : transfers_) {
      transfer.direction = direction;
      run.push_back(&transfer);
    }
    backend_.start_run(run);
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return pending_ == 0; });
  }
  std::span<std::byte> memory(std::uint64_t at) { return transfers_[at].memory; }
  void fill(std::uint32_t seed) {
    for (Transfer& transfer : transfers_)
      std::ranges::copy(make_content(transfer.memory.size(), Content::kRandom,
                                     seed + static_cast<std::uint32_t>(transfer.block)),
                        transfer.memory.begin());
  }
  bool has(std::uint64_t at, std::uint32_t seed) {
    const Transfer& transfer = transfers_[at];
    return std::ranges::equal(transfer.memory,
                              make_content(transfer.memory.size(), Content::kRandom,
                                           seed + static_cast<std::uint32_t>(transfer.block)));
  }
  /// Empty for a transfer that succeeded.
  std::string error(std::uint64_t at) {
    try {
      if (errors_[at]) std::rethrow_exception(errors_[at]);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

 private:
  void finished(Transfer& transfer, std::exception_ptr error) noexcept override {
    const std::scoped_lock lock(mutex_);
    errors_[transfer.tag] = error;
    if (--pending_ == 0) ended_.notify_all();
  }

  Backend& backend_;
  std::vector<std::byte> memory_;
  std::vector<Transfer> transfers_;
  std::vector<std::exception_ptr> errors_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t pending_ = 0;
};

struct RunShape {
  const char* what;
  LevelShape level;
};

/// Twenty blocks or so each.
const std::vector<RunShape> kRunShapes = {
    {"whole pages, and a short last block", {315, {}, 5, 16, 65536}},
    {"parts of pages", {300, {0, 1, 7, 40, 41, 42, 100, 150, 199}, 5, 12, 65536}},
    {"less than a page", {300, {}, 1, 12, 256}},
};

std::vector<BackendUnderTest> backends_with_runs() {
  std::vector<BackendUnderTest> result;
  for (const std::string& name : usable_backends())
    if (default_backends().find(name).traits.moves_runs)
      result.push_back({name, default_backends().find(name)});
  return result;
}

}  // namespace

TEST_CASE("BackendRun_WholePages_IsOneCallOnEveryBackend") {
  for (const BackendUnderTest& subject : backends_with_runs()) {
    INFO(subject.label);
    LevelUnderTest level(subject, {320, {}, 5, 16, 65536});
    Backend& backend = level.open();
    REQUIRE(level.geometry().block_count() == 20);
    MovedRun run(backend, level.geometry(), {2, 16});
    run.fill(1);
    CountedCalls calls;
    run.move(Way::kWrite);
    CHECK(calls.count == 1);
    run.move(Way::kRead);
    CHECK(calls.count == 2);
    for (std::uint64_t at = 0; at < 16; ++at) CHECK(run.has(at, 1));
    if (subject.label == "mmap") {
      MovedRun whole(backend, level.geometry(), {0, 20});
      whole.fill(1);
      whole.move(Way::kWrite);
      Backend& mapped = level.open(OpenMode::kRead);
      MovedRun at_its_address(mapped, level.geometry(), {2, 16});
      calls.count = 0;
      at_its_address.move(Way::kRead);
      CHECK(calls.count == 1);
      for (std::uint64_t at = 0; at < 16; ++at) CHECK(at_its_address.has(at, 1));
    }
  }
}

TEST_CASE("BackendRun_RandomRuns_AreTheBlocksWhateverTheCallsMove") {
  std::mt19937 random(5);
  for (const BackendUnderTest& subject : backends_with_runs())
    for (const RunShape& shape : kRunShapes) {
      LevelUnderTest level(subject, shape.level);
      Backend& backend = level.open();
      const LevelGeometry& geometry = level.geometry();
      std::vector<std::uint32_t> seeds(geometry.block_count(), 0);  // 0: never written
      for (int round = 0; round < unless_sanitized(40, 10); ++round) {
        const std::uint64_t first = random() % seeds.size();
        const std::uint64_t count = 1 + random() % (seeds.size() - first);
        INFO(subject.label << ", " << shape.what << ", round " << round << ", blocks " << first
                           << " and " << count << " in all");
        MovedRun run(backend, geometry, {first, count});
        CountedCalls calls;
        calls.interrupted = static_cast<int>(random() % 3);
        if (random() % 2 == 0) calls.most_bytes = 1 + random() % 200000;
        if (random() % 3 != 0) {
          const auto seed = static_cast<std::uint32_t>(1000 * (round + 1));
          run.fill(seed);
          run.move(Way::kWrite);
          for (std::uint64_t at = 0; at < count; ++at) {
            CHECK(run.error(at).empty());
            CHECK(run.has(at, seed));
            seeds[first + at] = seed;
          }
        } else {
          run.fill(77);
          run.move(Way::kRead);
          for (std::uint64_t at = 0; at < count; ++at) {
            CHECK(run.error(at).empty());
            const auto is_zero = [](std::byte byte) { return byte == std::byte{0}; };
            CHECK((seeds[first + at] == 0 ? std::ranges::all_of(run.memory(at), is_zero)
                                          : run.has(at, seeds[first + at])));
          }
        }
      }
      backend.sync(true);
      Backend& again = level.open(OpenMode::kRead);
      for (std::uint64_t block = 0; block < seeds.size(); ++block) {
        MovedRun one(again, geometry, {block, 1});
        one.move(Way::kRead);
        if (seeds[block] != 0) CHECK(one.has(0, seeds[block]));
      }
    }
}

TEST_CASE("BackendRun_BadPlace_FailsItsBlockAloneAndIsNamed") {
  for (const BackendUnderTest& subject : backends_with_runs())
    for (const RunShape& shape : {kRunShapes[0], kRunShapes[1]})
      for (const Way direction : {Way::kRead, Way::kWrite}) {
        INFO(subject.label << ", " << shape.what
                           << (direction == Way::kRead ? ", read" : ", write"));
        LevelUnderTest level(subject, shape.level);
        Backend& backend = level.open();
        const LevelGeometry& geometry = level.geometry();
        constexpr std::uint64_t kCount = 12, kBad = 5;
        MovedRun run(backend, geometry, {1, kCount});
        run.fill(1);
        run.move(Way::kWrite);
        if (direction == Way::kWrite) run.fill(2);
        {
          CountedCalls calls;
          calls.bad_byte = geometry.block_offset(1 + kBad) + geometry.block_bytes(1 + kBad) / 2;
          run.move(direction);
        }
        for (std::uint64_t at = 0; at < kCount; ++at) {
          CHECK(run.error(at).empty() == (at != kBad));
          if (at != kBad) CHECK(run.has(at, direction == Way::kWrite ? 2 : 1));
        }
        CHECK_THAT(run.error(kBad), Catch::Contains(level.name()));
        // What was not written keeps its checksum, and what was written has the new one.
        run.move(Way::kRead);
        for (std::uint64_t at = 0; at < kCount; ++at)
          if (at != kBad) CHECK(run.error(at).empty());
      }
}

TEST_CASE("BackendRun_FileCutShort_FailsWhatIsMissing") {
  for (const BackendUnderTest& subject : backends_with_runs()) {
    INFO(subject.label);
    LevelUnderTest level(subject, {320, {}, 5, 16, 65536});
    Backend& backend = level.open();
    MovedRun run(backend, level.geometry(), {0, 16});
    run.fill(1);
    run.move(Way::kWrite);
    std::filesystem::resize_file(level.file(), level.geometry().block_offset(7) + 4096);
    run.move(Way::kRead);
    for (std::uint64_t at = 0; at < 16; ++at) CHECK(run.error(at).empty() == (at < 7));
    CHECK_THAT(run.error(7),
               Catch::Contains(std::to_string(level.geometry().block_offset(7) + 4096)));
  }
}

}  // namespace plait::test
