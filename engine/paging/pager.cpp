#include "plait/pager.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

#include "paging/eviction.h"
#include "paging/frame_pool.h"
#include "plait/error.h"

namespace plait {

class Pager::Implementation {
 public:
  explicit Implementation(std::uint64_t budget_bytes)
      : pool_(budget_bytes), eviction_(make_eviction(EvictionPolicy::kWindow)) {}
  ~Implementation() {
    for (std::uint32_t frame = 0; frame < frames_.size(); ++frame)
      if (frames_[frame].level) drop(frame);
  }

  void attach(LevelFile& level);
  void detach(LevelFile& level);
  std::uint32_t pin(LevelFile& level, std::uint64_t block, Access access);
  void unpin(std::uint32_t entry) noexcept;
  void prefetch(LevelFile& level, BlockRange blocks) noexcept;
  void flush();
  void discard() noexcept;
  void set_policy(EvictionPolicy policy);

  std::span<std::byte> bytes(std::uint32_t frame) const {
    return {frames_[frame].memory, frames_[frame].block_bytes};
  }

  mutable std::mutex mutex_;
  FramePool pool_;
  PagingStatistics statistics_;

 private:
  struct Frame {
    LevelFile* level = nullptr;  ///< nullptr: this entry holds no block
    std::uint64_t block = 0;
    std::byte* memory = nullptr;
    std::uint64_t block_bytes = 0, frame_bytes = 0;
    std::uint32_t pins = 0;
    bool dirty = false;
    bool direct = false;
    EdgeId evictable_as = 0;  ///< what eviction_ was told, while pins == 0
  };
  /// Adds the time from construction to destruction to the waits.
  class Wait;

  std::uint32_t bring_in(LevelFile& level, std::uint64_t block, Access access);
  std::uint32_t new_frame_entry();
  void evict_one(const LevelFile& wanted_by, std::uint64_t wanted_bytes);
  void write_back(Frame& frame);
  void drop(std::uint32_t entry) noexcept;
  void make_evictable(std::uint32_t frame, EdgeId edge_after) {
    frames_[frame].evictable_as = edge_after;
    eviction_->insert(frame, edge_after);
  }
  void keep(std::uint32_t frame) { eviction_->erase(frame, frames_[frame].evictable_as); }

  std::unique_ptr<Eviction> eviction_;
  std::vector<Frame> frames_;
  std::vector<std::uint32_t> vacant_entries_;
  std::vector<std::vector<std::uint32_t>> resident_;  ///< [pager slot][block] frame or kNoId
  std::vector<std::uint32_t> vacant_slots_;
  bool failed_ = false;
};

class Pager::Implementation::Wait {
 public:
  explicit Wait(PagingStatistics& statistics)
      : statistics_(statistics), start_(std::chrono::steady_clock::now()) {}
  ~Wait() {
    ++statistics_.waits;
    statistics_.wait_ns += static_cast<std::uint64_t>(
        std::chrono::nanoseconds(std::chrono::steady_clock::now() - start_).count());
  }
  Wait(const Wait&) = delete;
  Wait& operator=(const Wait&) = delete;

 private:
  PagingStatistics& statistics_;
  std::chrono::steady_clock::time_point start_;
};

void Pager::Implementation::attach(LevelFile& level) {
  if (vacant_slots_.empty()) {
    level.pager_slot = static_cast<std::uint32_t>(resident_.size());
    resident_.emplace_back();
  } else {
    level.pager_slot = vacant_slots_.back();
    vacant_slots_.pop_back();
  }
  resident_[level.pager_slot].assign(level.geometry.block_count(), kNoId);
}

void Pager::Implementation::detach(LevelFile& level) {
  if (level.pager_slot == kNoId) return;
  for (const std::uint32_t frame : resident_[level.pager_slot])
    if (frame != kNoId) {
      keep(frame);
      drop(frame);
    }
  resident_[level.pager_slot].clear();
  vacant_slots_.push_back(std::exchange(level.pager_slot, kNoId));
}

std::uint32_t Pager::Implementation::pin(LevelFile& level, std::uint64_t block, Access access) {
  if (access != Access::kRead && failed_)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: refused since an earlier write failed; reopen the store",
                            level.path.native()));
  std::uint32_t frame = resident_[level.pager_slot][block];
  if (frame == kNoId) {
    frame = bring_in(level, block, access);
  } else if (frames_[frame].pins == 0) {
    keep(frame);
  }
  ++frames_[frame].pins;
  if (access != Access::kRead) frames_[frame].dirty = true;
  return frame;
}

std::uint32_t Pager::Implementation::bring_in(LevelFile& level, std::uint64_t block,
                                              Access access) {
  const bool written = level.table[block].encoding != BlockEncoding::kNeverWritten;
  // What a mapping holds for a block never written is not known to be zeros, and one opened for
  // reading cannot be cleared: such a block gets a frame of its own.
  const bool direct = level.backend->traits().direct && (written || level.writable);
  const std::uint64_t block_bytes = level.geometry.block_bytes(block);
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  std::byte* memory = nullptr;
  while (true) {
    if (direct) {
      if (pool_.reserve(frame_bytes)) {
        memory = level.backend->address(block);
        break;
      }
    } else {
      memory = pool_.take(frame_bytes);
      if (memory) break;
    }
    evict_one(level, frame_bytes);
  }

  const std::uint32_t entry = new_frame_entry();
  Frame& frame = frames_[entry];
  frame = {&level, block, memory, block_bytes, frame_bytes, 0, false, direct, 0};
  resident_[level.pager_slot][block] = entry;
  if (access != Access::kWrite) {
    try {
      if (!written) {
        std::memset(memory, 0, block_bytes);
      } else if (direct) {
        level.table.check(block, {memory, block_bytes}, level.path);
      } else {
        const Wait wait(statistics_);
        level.backend->read({block, 1}, {memory, block_bytes});
      }
    } catch (...) {
      drop(entry);
      throw;
    }
    if (written) {
      ++statistics_.blocks_read;
      statistics_.bytes_read += block_bytes;
    }
  }
#ifndef NDEBUG
  else if (!direct)
    std::memset(memory, 0xcd, block_bytes);
#endif
  return entry;
}

std::uint32_t Pager::Implementation::new_frame_entry() {
  if (vacant_entries_.empty()) {
    frames_.emplace_back();
    return static_cast<std::uint32_t>(frames_.size() - 1);
  }
  const std::uint32_t entry = vacant_entries_.back();
  vacant_entries_.pop_back();
  return entry;
}

void Pager::Implementation::evict_one(const LevelFile& wanted_by, std::uint64_t wanted_bytes) {
  const std::uint32_t victim = eviction_->victim();
  if (victim == kNoId)
    throw Error(ErrorCode::kBudget,
                fmt::format("page in {}: a frame of {} bytes is needed, and all {} bytes in frames "
                            "are pinned under a budget of {} bytes",
                            wanted_by.path.native(), wanted_bytes, pool_.used_bytes(),
                            pool_.budget_bytes()));
  Frame& frame = frames_[victim];
  if (frame.dirty) {
    if (failed_)
      throw Error(ErrorCode::kBadState,
                  fmt::format("page in {}: only blocks that an earlier failed write left behind "
                              "could make room; reopen the store",
                              wanted_by.path.native()));
    const Wait wait(statistics_);
    write_back(frame);
  }
  if (frame.direct) frame.level->backend->advise({frame.block, 1}, Advice::kDontNeed);
  keep(victim);
  drop(victim);
  ++statistics_.blocks_evicted;
}

void Pager::Implementation::write_back(Frame& frame) {
  LevelFile& level = *frame.level;
  try {
    if (frame.direct) {
      level.table.seal(frame.block, level.geometry.block_offset(frame.block), BlockEncoding::kRaw,
                       {frame.memory, frame.block_bytes});
      level.backend->flush({frame.block, 1});
    } else {
      level.backend->write({frame.block, 1}, {frame.memory, frame.block_bytes});
    }
  } catch (...) {
    failed_ = true;
    throw;
  }
  frame.dirty = false;
  ++statistics_.blocks_written;
  statistics_.bytes_written += frame.block_bytes;
}

void Pager::Implementation::drop(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (frame.direct)
    pool_.unreserve(frame.frame_bytes);
  else
    pool_.give_back(frame.memory, frame.frame_bytes);
  resident_[frame.level->pager_slot][frame.block] = kNoId;
  frame.level = nullptr;
  vacant_entries_.push_back(entry);
}

void Pager::Implementation::unpin(std::uint32_t entry) noexcept {
  Frame& frame = frames_[entry];
  if (--frame.pins == 0) make_evictable(entry, frame.level->geometry.edge_after(frame.block));
}

void Pager::Implementation::prefetch(LevelFile& level, BlockRange blocks) noexcept {
  for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
    if (resident_[level.pager_slot][block] != kNoId ||
        level.table[block].encoding == BlockEncoding::kNeverWritten)
      continue;
    level.backend->advise({block, 1}, Advice::kWillNeed);
    ++statistics_.blocks_prefetched;
  }
}

void Pager::Implementation::flush() {
  if (failed_)
    throw Error(ErrorCode::kBadState,
                "flush: refused since an earlier write failed; reopen the store");
  std::vector<Frame*> dirty;
  for (Frame& frame : frames_)
    if (frame.level && frame.dirty) dirty.push_back(&frame);
  std::ranges::sort(dirty, {}, [](const Frame* frame) {
    return std::pair(frame->level->pager_slot, frame->block);
  });
  const Wait wait(statistics_);
  for (Frame* frame : dirty) {
    write_back(*frame);
    frame->dirty = frame->pins > 0;
  }
}

void Pager::Implementation::discard() noexcept {
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry) {
    Frame& frame = frames_[entry];
    if (!frame.level || frame.pins > 0) continue;
    keep(entry);
    drop(entry);
  }
}

void Pager::Implementation::set_policy(EvictionPolicy policy) {
  eviction_ = make_eviction(policy);
  for (std::uint32_t entry = 0; entry < frames_.size(); ++entry)
    if (frames_[entry].level && frames_[entry].pins == 0) make_evictable(entry, 0);
}

PinnedBlock::PinnedBlock(PinnedBlock&& other) noexcept
    : pager_(std::exchange(other.pager_, nullptr)), frame_(other.frame_), bytes_(other.bytes_) {}

PinnedBlock& PinnedBlock::operator=(PinnedBlock&& other) noexcept {
  if (this != &other) {
    release();
    pager_ = std::exchange(other.pager_, nullptr);
    frame_ = other.frame_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void PinnedBlock::release() noexcept {
  if (!pager_) return;
  const std::scoped_lock lock(pager_->implementation_->mutex_);
  pager_->implementation_->unpin(frame_);
  pager_ = nullptr;
}

Pager::Pager(std::uint64_t budget_bytes)
    : implementation_(std::make_unique<Implementation>(budget_bytes)) {}
Pager::~Pager() = default;

void Pager::attach(LevelFile& level) {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->attach(level);
}

void Pager::detach(LevelFile& level) {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->detach(level);
}

PinnedBlock Pager::pin(LevelFile& level, std::uint64_t block, Access access) {
  const std::scoped_lock lock(implementation_->mutex_);
  PinnedBlock pinned;
  pinned.frame_ = implementation_->pin(level, block, access);
  pinned.bytes_ = implementation_->bytes(pinned.frame_);
  pinned.pager_ = this;
  return pinned;
}

void Pager::prefetch(LevelFile& level, BlockRange blocks) noexcept {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->prefetch(level, blocks);
}

void Pager::flush() {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->flush();
}

void Pager::discard() noexcept {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->discard();
}

void Pager::set_policy(EvictionPolicy policy) {
  const std::scoped_lock lock(implementation_->mutex_);
  implementation_->set_policy(policy);
}

std::uint64_t Pager::budget_bytes() const noexcept { return implementation_->pool_.budget_bytes(); }

PagingStatistics Pager::statistics() const {
  const std::scoped_lock lock(implementation_->mutex_);
  PagingStatistics statistics = implementation_->statistics_;
  statistics.peak_frame_bytes = implementation_->pool_.peak_bytes();
  return statistics;
}

}  // namespace plait
