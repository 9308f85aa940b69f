// A backend in memory that keeps its pages for the next store. A second store of the same size gets
// pages that were touched before, so a measurement does not include the time in which the operating
// system makes new pages. It is also an example of a backend outside the library.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "plait/extend/backend.h"
#include "plait/extend/backend_registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace plait::bench {

/// Mappings by size. Safe from several threads.
class RecycledPages {
 public:
  std::byte* take(std::uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    std::vector<std::byte*>& idle = idle_[bytes];
    if (!idle.empty()) {
      std::byte* memory = idle.back();
      idle.pop_back();
      return memory;
    }
    void* memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw Error(ErrorCode::kOutOfMemory, "map memory for a level");
    ::madvise(memory, bytes, MADV_HUGEPAGE);
    std::memset(memory, 0, bytes);
    return static_cast<std::byte*>(memory);
  }
  void give_back(std::byte* memory, std::uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    idle_[bytes].push_back(memory);
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, std::vector<std::byte*>> idle_;
};

class RecycledMemory final : public Backend {
 public:
  RecycledMemory(const LevelSpec& level, RecycledPages& pages)
      : geometry_(level.geometry),
        pages_(pages),
        mapped_bytes_(std::max<std::uint64_t>(geometry_.total_bytes(), 4096)),
        base_(pages.take(mapped_bytes_)) {}
  ~RecycledMemory() override { pages_.give_back(base_, mapped_bytes_); }
  RecycledMemory(const RecycledMemory&) = delete;
  RecycledMemory& operator=(const RecycledMemory&) = delete;

  static constexpr BackendTraits kTraits{.in_memory = true};
  void read(BlockRange blocks, std::span<std::byte> into) override {
    std::memcpy(into.data(), address(blocks.first), into.size());
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    std::memcpy(address(blocks.first), from.data(), from.size());
  }
  std::byte* address(std::uint64_t block) override { return base_ + geometry_.block_offset(block); }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return geometry_.total_bytes(); }

 private:
  const LevelGeometry& geometry_;
  RecycledPages& pages_;
  std::uint64_t mapped_bytes_;
  std::byte* base_;
};

/// `pages` must outlive all stores.
inline BackendRegistry recycled_memory(RecycledPages& pages) {
  BackendRegistry registry;
  registry.add({"recycled", "memory whose pages are touched already", RecycledMemory::kTraits,
                open_each_level([&pages](const LevelSpec& level) {
                  return std::make_unique<RecycledMemory>(level, pages);
                })});
  return registry;
}

/// A store of the base positions, in memory that was touched before if there was a store of the
/// same size. `backends`: of recycled_memory().
inline Store recycled_store(BaseMesh base, const BackendRegistry& backends) {
  StoreOptions options;
  options.backend = "recycled";
  options.budget_bytes = std::uint64_t{1} << 40;  // nothing is ever evicted
  Store store = Store::create({}, std::move(base), options, backends);
  add_base_positions(store);
  return store;
}

}  // namespace plait::bench
