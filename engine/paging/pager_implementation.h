// The pager: joins what each know a part of. FrameTable has the blocks and their memory, Sessions
// whose frames go first, Transfers what is on its way. All of them are under one lock, which is let
// go while bytes move.
//
// Its sources: pager.cpp (levels, sessions, pins), pager_frames.cpp (frames are had and given up),
// pager_transfers.cpp (transfers end, reading ahead, flush). A pin that must wait is a PinCall.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "paging/frame_table.h"
#include "paging/sessions.h"
#include "paging/transfers.h"
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
  void flush();
  void refuse_writes() noexcept;
  void discard() noexcept;
  void set_aside(std::uint64_t bytes) noexcept;
  std::uint64_t budget_bytes() const noexcept;
  PagingStatistics statistics() const;

  // For sessions.
  SessionState& open_session(const SessionOptions& options);
  void end_session(SessionState& session) noexcept;
  /// Pins requests[i] in frames[i], for the caller with the number that it returns.
  /// Errors: those of Session::pin_many.
  std::uint32_t pin(SessionState& session, std::span<const BlockRequest> requests,
                    std::span<Frame*> frames);
  /// `written`: the level, of a pin for writing.
  void unpin(SessionState& session, std::uint32_t caller, Frame& frame, LevelFile* written,
             bool abandon) noexcept;
  bool prefetch(SessionState& session, const LevelFile& level, std::uint64_t block) noexcept;
  PagingStatistics statistics(const SessionState& session) const;

  void finished(Transfer& transfer, std::exception_ptr error) noexcept override;

 private:
  using Lock = std::unique_lock<std::mutex>;
  using Direction = Transfer::Direction;
  using State = Frame::State;

  /// Adds the time from construction to destruction to the waits of one direction, for a session
  /// too unless that is nullptr.
  class Wait;

  class PinCall;
  /// The frame, if the block can be pinned without waiting and without any other block.
  Frame* find_ready(const BlockRequest& request) noexcept;

  // pager_frames.cpp
  /// A frame for a block that has none, or nullptr. Errors: those of Backend::address;
  /// std::bad_alloc.
  Frame* take_frame(SessionState& session, const LevelFile& level, std::uint64_t block);
  /// The next to be evicted if it is clean; otherwise nullptr.
  Frame* clean_victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  void evict(Lock& lock, Frame& frame) noexcept;
  /// The frame is pinned once more, and belongs to this session.
  void hold(SessionState& session, Frame& frame) noexcept;
  /// A pin of it is for writing: it is dirty.
  void add_writer(Frame& frame) noexcept;
  /// Pinned once less.
  void let_go(Frame& frame) noexcept;
  /// Nobody pins the frame: where does it go?
  void settle(Frame& frame) noexcept;
  /// The block leaves the memory.
  void drop(Frame& frame) noexcept;
  void drop_context(Frame& frame) noexcept;

  // pager_transfers.cpp
  bool begin_prefetch(Lock& lock, SessionState& session, const LevelFile& level,
                      std::uint64_t block);
  void write_in_memory(Frame& frame) noexcept;
  void write_here(Lock& lock, SessionState* session, Frame& frame);
  void abandon(Lock& lock, Frame& frame, LevelFile& level) noexcept;
  void fail(std::exception_ptr error) noexcept;
  /// Takes back what no thread has begun for this level, or for all if nullptr; waits for the rest.
  void stop_transfers(Lock& lock, const LevelFile* level) noexcept;
  void wait_for_any(Lock& lock, SessionState* session, Direction direction) noexcept;
  void wait_while(Lock& lock, SessionState& session, Frame& frame, bool (*what)(State)) noexcept;
  void wait_for_change(Lock& lock, std::uint64_t since) noexcept {
    changed_.wait(lock, [&] { return changes_ != since; });
  }
  void tell_of_change() noexcept;
  void count_transfer(const Frame& frame, Direction direction) noexcept;

  bool writes_behind(const SessionState* session) const {
    return transfers_.has_threads() &&
           !(session && session->options.policy == EvictionPolicy::kClock);
  }
  static bool was_written(const LevelFile& level, std::uint64_t block) {
    return level.table[block].encoding != BlockEncoding::kNeverWritten;
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< a transfer or a wait for one ended, or a pin
  std::uint64_t changes_ = 0;

  PagingStatistics statistics_;
  FrameTable table_;
  Sessions sessions_;
  /// Calls that pin blocks and do not wait for room: the frames that they hold may come free.
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

}  // namespace plait
