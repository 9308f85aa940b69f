// Blocks that share pages of the file, written by several threads at once with several of them on
// their way: no byte of a neighbour may be lost. A level with border edges has such blocks, and so
// has one whose blocks are smaller than a page.
#include <atomic>
#include <catch2/catch.hpp>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "backends/conformance.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

/// Waits for its transfers.
class Gate final : public TransferListener {
 public:
  void finished(Transfer&, std::exception_ptr error) noexcept override {
    const std::scoped_lock lock(mutex_);
    if (error) ++errors;
    if (--pending == 0) ended_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return pending == 0; });
  }
  int pending = 0, errors = 0;

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
};

void write_from_threads(LevelUnderTest& level, Backend& backend) {
  const LevelGeometry& geometry = level.geometry();
  constexpr std::uint64_t kWriters = 4;
  std::atomic<int> errors = 0;
  const auto work = [&](std::uint64_t first) {
    std::vector<Transfer> transfers;
    std::vector<std::vector<std::byte>> contents;
    Gate gate;
    for (std::uint64_t block = first; block < geometry.block_count(); block += kWriters) {
      contents.push_back(make_content(geometry.block_bytes(block), Content::kRandom,
                                      static_cast<std::uint32_t>(block)));
      transfers.push_back({.direction = Transfer::Direction::kWrite,
                           .block = block,
                           .memory = contents.back(),
                           .listener = &gate});
    }
    gate.pending = static_cast<int>(transfers.size());
    for (Transfer& transfer : transfers) backend.start(transfer);
    gate.wait();
    errors += gate.errors;
  };
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < kWriters; ++i) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
  REQUIRE(errors == 0);
}

}  // namespace

TEST_CASE("BackendStart_NeighboursThatSharePages_LoseNoByte") {
  const std::vector<LevelShape> shapes = {
      {200, {0, 1, 7, 40, 41, 42, 100, 150, 199}, 5, 12, 16384},  // pages and parts of pages
      {300, {}, 1, 12, 4096},                                     // parts of pages only
      {40, {3, 17}, 5, 12, 4096},
      {64, {}, 5, 16, 65536},  // pages only
  };
  for (const std::string& name : usable_backends()) {
    if (name == "memory") continue;
    const BackendUnderTest subject{name, default_backends().find(name),
                                   name == "compressed" ? "lz4" : "none"};
    for (const LevelShape& shape : shapes) {
      INFO(name << ", record bytes " << shape.record_bytes << ", edges " << shape.edge_count);
      LevelUnderTest level(subject, shape);
      Backend& backend = level.open();
      write_from_threads(level, backend);
      backend.sync(true);
      for (const bool again : {false, true}) {
        Backend& reader = again ? level.open(OpenMode::kRead) : backend;
        bool same = true;
        for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block)
          same = same && read_blocks(reader, level.geometry(), {block, 1}) ==
                             make_content(level.geometry().block_bytes(block), Content::kRandom,
                                          static_cast<std::uint32_t>(block));
        CHECK(same);
      }
    }
  }
}

TEST_CASE("RawBackends_FileOfOne_IsTheFileOfAnother") {
  const LevelShape shape{200, {0, 1, 7, 40, 150}, 5, 12, 16384};
  for (const std::string& writer : usable_backends())
    for (const std::string& reader : usable_backends()) {
      const auto& from = default_backends().find(writer);
      const auto& to = default_backends().find(reader);
      if (!from.traits.overwrites_in_place || !to.traits.overwrites_in_place) continue;
      INFO(writer << " to " << reader);
      const BackendUnderTest subject{writer, from};
      LevelUnderTest level(subject, shape);
      const auto content = make_content(level.geometry().total_bytes(), Content::kRandom, 3);
      level.open().write({0, level.geometry().block_count()}, content);
      level.close();
      const auto volume = to.open({});
      const auto other = volume->open_level(
          {level.directory(), level.name(), OpenMode::kRead, level.geometry(), level.table()});
      CHECK(read_blocks(*other, level.geometry(), {0, level.geometry().block_count()}) == content);
    }
}

}  // namespace plait::test
