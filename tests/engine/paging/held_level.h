// tests/engine/paging/held_level.h: a level whose transfers end when the test says so, in the order
// it says.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "engine/paging/waiting.h"
#include "plait/error.h"
#include "plait/extend/pager.h"

namespace plait::test {

using Direction = Transfer::Direction;

/// Keeps transfers until they are let go; at most `limit` of them pass by themselves.
class HeldBackend final : public Backend {
 public:
  explicit HeldBackend(const LevelSpec& spec) : spec_(spec), bytes_(spec.geometry.total_bytes()) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    std::memcpy(into.data(), place(blocks.first), into.size());
    spec_.table.check(blocks.first, into, "held");
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (fail_writes) throw Error(ErrorCode::kNoSpace, "held: full");
    std::memcpy(place(blocks.first), from.data(), from.size());
    spec_.table.seal(blocks.first, spec_.geometry.block_offset(blocks.first), BlockEncoding::kRaw,
                     from);
  }
  void start(Transfer& transfer) noexcept override {
    {
      const std::scoped_lock lock(mutex_);
      ++(transfer.direction == Direction::kRead ? started_reads : started_writes);
      started_.notify_all();
      if (holding_) {
        held_.emplace(std::pair(transfer.direction, transfer.block), &transfer);
        return;
      }
    }
    Backend::start(transfer);
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return bytes_.size(); }

  void hold() {
    const std::scoped_lock lock(mutex_);
    holding_ = true;
  }
  /// Waits until this transfer has begun, then ends it, with an error if `code` is one.
  void let_go(Direction direction, std::uint64_t block, bool fail = false) {
    Transfer* transfer = nullptr;
    {
      std::unique_lock lock(mutex_);
      started_.wait(lock, [&] { return held_.contains({direction, block}); });
      transfer = held_.extract({direction, block}).mapped();
    }
    if (fail)
      transfer->listener->finished(
          *transfer, std::make_exception_ptr(Error(ErrorCode::kNoSpace, "held: full")));
    else
      Backend::start(*transfer);
  }
  void let_all_go() {
    std::map<std::pair<Direction, std::uint64_t>, Transfer*> held;
    {
      const std::scoped_lock lock(mutex_);
      holding_ = false;
      held.swap(held_);
    }
    for (const auto& [what, transfer] : held) Backend::start(*transfer);
  }
  void wait_until_started(int reads, int writes) {
    std::unique_lock lock(mutex_);
    started_.wait(lock, [&] { return started_reads >= reads && started_writes >= writes; });
  }
  std::atomic<int> started_reads = 0, started_writes = 0;
  std::atomic<bool> fail_writes = false;

 private:
  std::byte* place(std::uint64_t block) {
    return bytes_.data() + spec_.geometry.block_offset(block);
  }
  LevelSpec spec_;
  std::vector<std::byte> bytes_;
  std::mutex mutex_;
  std::condition_variable started_;
  bool holding_ = false;
  std::map<std::pair<Direction, std::uint64_t>, Transfer*> held_;
};

/// One level of blocks of 4096 one-byte records, block b filled with b + 1 on the "disk".
struct HeldLevel {
  HeldLevel(Pager& its_pager, std::uint64_t blocks, const SessionOptions& options = {})
      : pager(its_pager), session(pager.open_session(options)) {
    file.geometry = LevelGeometry(SlotShapes(blocks * 4096), BaseRelativeLevel(1), 1, kBlockBytes);
    file.table = BlockTable({}, 0, 1, file.geometry.block_count());
    auto made = std::make_unique<HeldBackend>(
        LevelSpec{directory, "held", OpenMode::kCreate, file.geometry, file.table, {}});
    backend = made.get();
    file.backend = std::move(made);
    for (std::uint64_t block = 0; block < blocks; ++block)
      backend->write({block, 1}, std::vector<std::byte>(kBlockBytes, value(block)));
    pager.attach(file);
  }
  ~HeldLevel() { pager.detach(file); }
  HeldLevel(const HeldLevel&) = delete;
  HeldLevel& operator=(const HeldLevel&) = delete;
  static std::byte value(std::uint64_t block) { return static_cast<std::byte>(block + 1); }
  PinnedBlock pin(std::uint64_t block, Access access) { return session.pin(file, block, access); }
  void put(std::uint64_t block, int byte) {
    std::memset(pin(block, Access::kOverwrite).bytes().data(), byte, kBlockBytes);
  }

  Directory directory;
  LevelFile file;
  HeldBackend* backend = nullptr;
  Pager& pager;
  Session session;
};

}  // namespace plait::test
