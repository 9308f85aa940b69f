// tests/engine/paging/fake_level.h: a level whose backend is an array, for tests of the pager.
#pragma once

#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "engine/paging/waiting.h"
#include "plait/error.h"
#include "plait/extend/pager.h"

namespace plait::test {

/// Keeps blocks in memory, behind copies or behind addresses, counts and fails on demand.
class FakeBackend final : public Backend {
 public:
  explicit FakeBackend(const LevelSpec& spec) : spec_(spec), bytes_(spec.geometry.total_bytes()) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    ++reads;
    if (into.data() != address_of(blocks.first))
      std::memcpy(into.data(), address_of(blocks.first), into.size());
    spec_.table.check(blocks.first, into, "fake");
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    ++writes;
    if (fail_writes) throw Error(ErrorCode::kNoSpace, "fake: full");
    if (from.data() != address_of(blocks.first))
      std::memcpy(address_of(blocks.first), from.data(), from.size());
    spec_.table.seal(blocks.first, spec_.geometry.block_offset(blocks.first), BlockEncoding::kRaw,
                     from);
  }
  std::byte* address(std::uint64_t block) override {
    if (before_address) before_address();
    if (fail_addresses) throw Error(ErrorCode::kCorruption, "fake: cut short");
    return address_of(block);
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return bytes_.size(); }

  std::byte* address_of(std::uint64_t block) {
    return bytes_.data() + spec_.geometry.block_offset(block);
  }
  std::atomic<int> reads = 0, writes = 0;
  std::atomic<bool> fail_writes = false, fail_addresses = false;
  std::function<void()> before_address;  ///< called with the pager's lock

 private:
  LevelSpec spec_;
  std::vector<std::byte> bytes_;
};

/// Frames, frames that are the blocks themselves, and a mapping that is only read.
inline constexpr BackendTraits kFramed{.durable = true}, kInMemory{.in_memory = true},
    kMapped{.durable = true, .maps_for_reading = true};

/// A level of one-byte records: 4096 edges a block at level 1, 1024 at level 2, ...
struct TestLevel {
  TestLevel(Pager& its_pager, int level, std::uint64_t edges, const BackendTraits& traits = kFramed)
      : pager(its_pager) {
    file.path = "fake";
    file.traits = traits;
    file.writable = !traits.maps_for_reading;
    file.geometry = LevelGeometry(SlotShapes(edges), BaseRelativeLevel(level), 1, kBlockBytes);
    file.table = BlockTable({}, 0, level, file.geometry.block_count());
    auto made = std::make_unique<FakeBackend>(
        LevelSpec{directory, "fake", OpenMode::kCreate, file.geometry, file.table, {}});
    backend = made.get();
    file.backend = std::move(made);
    pager.attach(file);
  }
  ~TestLevel() { pager.detach(file); }
  TestLevel(const TestLevel&) = delete;
  TestLevel& operator=(const TestLevel&) = delete;
  void put_on_disk(std::uint64_t block, unsigned char value) const {
    backend->write({block, 1}, std::vector<std::byte>(kBlockBytes, static_cast<std::byte>(value)));
  }
  Directory directory;
  LevelFile file;
  FakeBackend* backend = nullptr;
  Pager& pager;
};

inline void fill(const PinnedBlock& pinned, unsigned char value) {
  std::memset(pinned.bytes().data(), value, pinned.bytes().size());
}

inline bool holds(const PinnedBlock& pinned, unsigned char value) {
  for (const std::byte byte : pinned.bytes())
    if (byte != static_cast<std::byte>(value)) return false;
  return true;
}

}  // namespace plait::test
