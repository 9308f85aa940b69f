// The implementation of the pager. It has three parts: FrameTable knows the blocks and their
// memory, Sessions decides which frame is evicted next, and Transfers starts reads and writes. One
// lock protects all of them; the pager releases it while a backend moves bytes. A pin of a block
// that is in memory takes no lock, nor does its end (paging/pin_count.h).
// Sources: pager.cpp (levels, sessions, pins), pager_frames.cpp (taking and freeing frames),
// pager_transfers.cpp (ends of transfers, prefetch, flush). A pin that may have to wait is a
// PinCall.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <span>

#include "io/process.h"
#include "paging/frame_table.h"
#include "paging/sessions.h"
#include "paging/transfers.h"
#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class Pager::Implementation final : public TransferListener {
 public:
  Implementation(std::uint64_t budget_bytes, int io_threads, StoreEvents events);
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// False in a process that was forked from the pager's. There, calls that can fail refuse, and
  /// the others do nothing: the threads are missing, and one of them may have had the lock.
  bool is_usable() const noexcept { return process_.is_current(); }

  void attach(LevelFile& level);
  void detach(LevelFile& level);
  void flush();
  void wait_for_writes() noexcept;
  void refuse_writes() noexcept;
  void discard() noexcept;
  void set_aside(std::uint64_t bytes) noexcept;
  void lend(std::int64_t bytes) noexcept;
  std::uint64_t budget_bytes() const noexcept;
  PagingStatistics statistics() const;

  // Called by sessions.
  SessionState& open_session(const SessionOptions& options);
  void end_session(SessionState& session) noexcept;
  /// Pins requests[i] in frames[i]. Returns where the pins of the calling thread are counted.
  /// Errors: those of Session::pin_many.
  SessionCaller& pin(SessionState& session, std::span<const BlockRequest> requests,
                     std::span<Frame*> frames);
  using Lock = std::unique_lock<std::mutex>;
  /// The lock, for a thread that pins or unpins.
  Lock lock() noexcept;
  /// To end pins: unpin() for each of them, with one `lock` for all; it is taken when it is needed.
  /// Then unpinned(). Then end_pins(), with the number of pins that `caller` had among them.
  /// `written` is the level if the pin was for writing, otherwise nullptr.
  void unpin(Lock& lock, Frame& frame, LevelFile* written, bool abandon) noexcept;
  void unpinned(Lock& lock) noexcept;
  /// REQUIRES: the calling thread does not have the lock.
  void end_pins(SessionState& session, SessionCaller& caller, std::uint32_t pins) noexcept;
  /// Reads at most `count` blocks, of one run.
  bool prefetch(SessionState& session, const LevelFile& level, std::uint64_t block,
                std::uint64_t count) noexcept;
  bool read_ahead(SessionState& session, const LevelFile& level, std::uint64_t block,
                  std::uint64_t count) noexcept;
  void end_prefetch(SessionState& session) noexcept;
  PagingStatistics statistics(const SessionState& session) const;

  void finished(Transfer& transfer, std::exception_ptr error) noexcept override;

 private:
  using Direction = Transfer::Direction;
  using State = Frame::State;

  /// One byte of this many of the budget may wait for the rest of a run (Transfers::queue_write):
  /// half a run of each level of a usual build in 64 MiB.
  static constexpr std::uint64_t kPartThatWaits = 8;

  /// Adds the time from its construction to its destruction to the statistics of waits for one
  /// direction, and to those of a session unless that is nullptr.
  class Wait;

  class PinCall;
  /// Pins the blocks without the lock, if all are in frames that are open. Otherwise it pins none
  /// and returns nullptr.
  SessionCaller* pin_open(SessionState& session, std::span<const BlockRequest> requests,
                          std::span<Frame*> frames) noexcept;
  /// The frame of the block if it can be pinned without waiting and without other blocks, otherwise
  /// nullptr.
  Frame* find_ready(const BlockRequest& request) noexcept;
  /// The same for one request, or for several for reading. Returns false if one of them has none.
  bool find_ready(std::span<const BlockRequest> requests, std::span<Frame*> frames) noexcept;

  // pager_frames.cpp
  /// Takes a frame for a block that has none. Returns nullptr if the budget has no room. Errors:
  /// those of Backend::address; std::bad_alloc.
  Frame* take_frame(SessionState& session, const LevelFile& level, std::uint64_t block);
  /// The frame that would be evicted next, if it is clean; otherwise nullptr.
  Frame* clean_victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  void evict(Lock& lock, Frame& frame) noexcept;
  /// Evicts a block that a session which only writes has written, if the session has enough frames.
  /// Returns whether it did. It may release the lock.
  bool evict_written(Lock& lock, SessionState& session) noexcept;
  /// Whether threads of the frame's session may pin it without the lock: nothing of what add_pin()
  /// does would change the frame.
  static bool may_open(const Frame& frame) noexcept;
  /// Opens the frame, if it may be open. REQUIRES: it is placed, or it has a pin.
  static void open(Frame& frame) noexcept;
  /// Adds a pin to the frame, gives the frame to this session, and sets its place in layout order.
  void add_pin(SessionState& session, Frame& frame, EdgeId order) noexcept;
  /// Counts a pin for writing, and makes the frame dirty.
  void add_writer(Frame& frame) noexcept;
  /// Removes a pin from the frame. REQUIRES: the caller has the lock.
  void remove_pin(Frame& frame) noexcept;
  /// Called when a frame has no pin any more: frees it, queues its write, or makes it a candidate
  /// for eviction.
  void place_unpinned(Frame& frame) noexcept;
  /// Removes the block from memory without writing it, and frees the frame.
  void drop(Frame& frame) noexcept;
  void drop_context(Frame& frame) noexcept;

  // pager_transfers.cpp
  /// Begins to read the first of these blocks ahead, and with it those behind it that are absent
  /// and have room. They are of one run.
  bool begin_prefetch(Lock& lock, SessionState& session, const LevelFile& level, BlockRange blocks,
                      EdgeId order);
  /// Whether the part of the session's share that prefetch() uses has room for a block.
  bool has_share_for(const SessionState& session, const LevelFile& level) const noexcept;
  /// Takes a frame for an absent block, and evicts clean blocks for that. Returns nullptr if there
  /// is none, or if the block has one meanwhile. Errors: those of take_frame().
  Frame* take_frame_ahead(Lock& lock, SessionState& session, const LevelFile& level,
                          std::uint64_t block);
  void add_read_ahead(TransferRun& run, SessionState& session, Frame& frame) noexcept;
  std::size_t write_run(Lock& lock, std::span<Frame* const> frames) noexcept;
  void write_in_memory(Frame& frame) noexcept;
  void write_here(Lock& lock, SessionState* session, Frame& frame);
  void abandon(Lock& lock, Frame& frame, LevelFile& level) noexcept;
  void fail(std::exception_ptr error) noexcept;
  /// Withdraws the queued transfers of this level (nullptr: of all levels) that have not begun, and
  /// waits for the others.
  void stop_transfers(Lock& lock, const LevelFile* level) noexcept;
  void wait_for_any(Lock& lock, SessionState* session, Direction direction) noexcept;
  void wait_while(Lock& lock, SessionState& session, Frame& frame, bool (*what)(State)) noexcept;
  void wait_for_change(Lock& lock, std::uint64_t since) noexcept {
    changed_.wait(lock, [&] { return changes_ != since; });
  }
  void wake_all() noexcept;
  /// The same if only this frame may be one that a thread waits for. Wakes few threads.
  void wake_waiters_of(const Frame& frame) noexcept;
  /// Where a thread waits for a change of this frame alone.
  std::condition_variable& changed_of(const Frame& frame) noexcept {
    return frame_changed_[frame.index % frame_changed_.size()];
  }
  void count_transfer(const Frame& frame, Direction direction) noexcept;

  bool writes_behind(const SessionState* session) const {
    return transfers_.has_threads() &&
           !(session && session->options.policy == EvictionPolicy::kClock);
  }
  static bool was_written(const LevelFile& level, std::uint64_t block) {
    return level.table.may_be_written(block);
  }

  void check_usable() const { process_.check("a store"); }
  /// Tells `events_` of a frame's block, without the lock.
  void tell(Lock& lock, StoreEvent::Kind kind, const Frame::Content& content,
            std::uint64_t duration_ns = 0) noexcept;

  const OwnProcess process_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< notified when a transfer, a PinCall or a pin ends
  /// The same for threads that wait for one frame. Several frames share one of them.
  std::array<std::condition_variable, 16> frame_changed_;
  std::uint64_t changes_ = 0;

  PagingStatistics statistics_;
  const StoreEvents events_;
  FrameTable table_;
  Sessions sessions_;
  /// PinCalls that are not waiting for a free frame. They may free frames that they have taken.
  std::uint32_t calls_under_way_ = 0;
  Transfers transfers_;  ///< last: its threads end first
};

class Pager::Implementation::Wait {
 public:
  Wait(Implementation& pager, SessionState* session, Direction direction)
      : pager_(pager),
        session_(session),
        direction_(direction),
        start_(std::chrono::steady_clock::now()) {}
  ~Wait() {
    const auto passed = static_cast<std::uint64_t>(
        std::chrono::nanoseconds(std::chrono::steady_clock::now() - start_).count());
    add(pager_.statistics_, passed);
    if (session_) add(session_->statistics, passed);
  }
  Wait(const Wait&) = delete;
  Wait& operator=(const Wait&) = delete;

 private:
  void add(PagingStatistics& statistics, std::uint64_t passed_ns) const {
    const bool read = direction_ == Direction::kRead;
    ++(read ? statistics.read_waits : statistics.write_waits);
    (read ? statistics.read_wait_ns : statistics.write_wait_ns) += passed_ns;
  }

  Implementation& pager_;
  SessionState* session_;
  Direction direction_;
  std::chrono::steady_clock::time_point start_;
};

PLAIT_END_NAMESPACE
