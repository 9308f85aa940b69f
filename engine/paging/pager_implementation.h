// What the pager knows, shared by the files that implement it: pager.cpp (pins), pager_frames.cpp
// (which block has which frame) and pager_transfers.cpp (what is on its way).
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "paging/eviction.h"
#include "paging/frame_pool.h"
#include "paging/io_queue.h"
#include "plait/pager.h"

namespace plait {

class Pager::Implementation final : public TransferListener {
 public:
  Implementation(std::uint64_t budget_bytes, int io_threads);
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void attach(LevelFile& level);
  void detach(LevelFile& level);
  /// The frame, and its bytes.
  std::pair<std::uint32_t, std::span<std::byte>> pin(LevelFile& level, std::uint64_t block,
                                                     Access access);
  void unpin(std::uint32_t entry, bool abandoned) noexcept;
  bool prefetch(LevelFile& level, std::uint64_t block) noexcept;
  void flush();
  void refuse_writes() noexcept;
  void discard() noexcept;
  void set_policy(EvictionPolicy policy, std::uint64_t window_bytes);
  std::uint64_t budget_bytes() const { return pool_.budget_bytes(); }
  PagingStatistics statistics() const;

  void finished(Transfer& transfer, std::exception_ptr error) noexcept override;

 private:
  using Lock = std::unique_lock<std::mutex>;
  using Direction = Transfer::Direction;

  enum class Activity : std::uint8_t { kNone, kReading, kWriting };

  struct Frame {
    LevelFile* level = nullptr;  ///< nullptr: this entry holds no block
    std::uint64_t block = 0;
    std::byte* memory = nullptr;
    std::uint64_t block_bytes = 0, frame_bytes = 0;
    std::uint32_t pins = 0;
    std::uint32_t sweep = 0;  ///< the last one that used it
    Activity activity = Activity::kNone;
    bool direct = false;
    bool dirty = false;
    bool abandoned = false;  ///< is dropped with its last pin
    bool announced = false;  ///< prefetched, and not pinned since
    bool waiting = false;    ///< is in to_write_
    bool evictable = false;  ///< is in eviction_
    EdgeId evictable_as = 0;
    Transfer transfer;
    std::exception_ptr read_error;  ///< for the one that pinned it to read it
  };

  /// Adds the time from construction to destruction to the waits of one direction.
  class Wait;

  // pager_frames.cpp
  /// A frame for the block, pinned once, or kNoId if it had to let go of the lock on the way:
  /// somebody else may have brought the block in.
  std::uint32_t claim(Lock& lock, LevelFile& level, std::uint64_t block);
  /// A frame from what is free, or kNoId.
  std::uint32_t take_frame(LevelFile& level, std::uint64_t block);
  /// Frees a frame, or waits until that may be tried again. False: it let go of the lock.
  bool make_room(Lock& lock, const LevelFile& wanted_by, std::uint64_t wanted_bytes);
  std::uint32_t clean_victim();
  /// A frame that can be had without writing, or kNoId.
  std::uint32_t take_clean_frame(LevelFile& level, std::uint64_t block) noexcept;
  void evict(std::uint32_t entry) noexcept;
  /// Tells direct backends what was evicted. Not under the lock.
  void say_goodbye(Lock& lock) noexcept;
  void drop(std::uint32_t entry) noexcept;
  /// The last pin or transfer of a frame ended: where does it go?
  void settle(std::uint32_t entry) noexcept;
  /// The frame is about to be used: takes it out of where settle() put it.
  void unsettle(std::uint32_t entry) noexcept;
  void announce(std::uint32_t entry) noexcept;
  void unannounce(std::uint32_t entry) noexcept;

  // pager_transfers.cpp
  void bring_in(Lock& lock, std::uint32_t entry, Access access);
  void start(Lock& lock, std::uint32_t entry);
  void wait(Lock& lock, Direction direction);
  void wait_for(Lock& lock, std::uint32_t entry);
  void wait_for_change(Lock& lock, std::uint64_t since) {
    changed_.wait(lock, [&] { return changes_ != since; });
  }
  void begin_write(std::uint32_t entry) noexcept;
  /// What writing a block in memory amounts to.
  void mark_written(std::uint32_t entry) noexcept;
  void write_here(Lock& lock, std::uint32_t entry);
  void write_behind() noexcept;
  /// Takes back what is queued for this level, or for all if nullptr, and waits for the rest.
  void stop_transfers(Lock& lock, const LevelFile* level) noexcept;
  void fail(std::exception_ptr error) noexcept;
  [[noreturn]] void refuse(std::string_view what);
  void count_transfer(const Frame& frame, Direction direction) noexcept;

  bool writes_behind() const { return policy_ == EvictionPolicy::kWindow && queue_.has_threads(); }
  static bool is_memory(const LevelFile& level) { return level.traits.in_memory; }

  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< some transfer ended
  std::uint64_t changes_ = 0;

  FramePool pool_;
  PagingStatistics statistics_;
  EvictionPolicy policy_ = EvictionPolicy::kWindow;
  std::uint32_t sweep_ = 0;  ///< counts calls of set_policy()
  std::unique_ptr<Eviction> eviction_;
  std::deque<Frame> frames_;  ///< a deque, because transfers stay where they are
  std::vector<std::uint32_t> vacant_entries_;
  std::vector<std::vector<std::uint32_t>> resident_;  ///< [pager slot][block] frame or kNoId
  std::vector<std::uint32_t> vacant_slots_;
  std::set<std::pair<EdgeId, std::uint32_t>> announced_;  ///< resident; the last are needed last
  std::uint64_t announced_bytes_ = 0, window_bytes_ = 0;
  std::deque<std::uint32_t> to_write_;  ///< dirty and not pinned, oldest first
  std::uint32_t reads_ahead_ = 0, writes_in_flight_ = 0;
  std::vector<std::pair<Backend*, std::uint64_t>> evicted_;  ///< for say_goodbye()
  bool failed_ = false;
  std::exception_ptr failure_;  ///< not reported yet

  IoQueue queue_;  ///< last: its threads end first
};

class Pager::Implementation::Wait {
 public:
  Wait(PagingStatistics& statistics, Direction direction)
      : statistics_(statistics), direction_(direction), start_(std::chrono::steady_clock::now()) {}
  ~Wait() {
    const auto passed = static_cast<std::uint64_t>(
        std::chrono::nanoseconds(std::chrono::steady_clock::now() - start_).count());
    const bool read = direction_ == Direction::kRead;
    ++(read ? statistics_.read_waits : statistics_.write_waits);
    (read ? statistics_.read_wait_ns : statistics_.write_wait_ns) += passed;
  }
  Wait(const Wait&) = delete;
  Wait& operator=(const Wait&) = delete;

 private:
  PagingStatistics& statistics_;
  Direction direction_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace plait
