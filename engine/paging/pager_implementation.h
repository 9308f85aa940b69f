// What the pager knows, shared by the files that implement it: pager.cpp (pins), pager_frames.cpp
// (which block has which frame) and pager_transfers.cpp (what is on its way).
//
// A function that is noexcept allocates nothing: frames are linked by what is in them.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <vector>

#include "paging/eviction.h"
#include "paging/frame.h"
#include "paging/frame_pool.h"
#include "paging/io_queue.h"
#include "paging/session_state.h"
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
  SessionState& open_session(const SessionOptions& options);
  void end_session(SessionState& session) noexcept;
  Frame& pin(SessionState& session, const BlockRequest& request, std::uint32_t& caller);
  void unpin(SessionState& session, std::uint32_t caller, std::uint32_t index,
             LevelFile* abandoned) noexcept;
  bool prefetch(SessionState& session, const LevelFile& level, std::uint64_t block) noexcept;
  PagingStatistics statistics(const SessionState& session) const;
  void flush();
  void refuse_writes() noexcept;
  void discard() noexcept;
  void set_aside(std::uint64_t bytes) noexcept;
  std::uint64_t budget_bytes() const noexcept;
  PagingStatistics statistics() const;

  void finished(Transfer& transfer, std::exception_ptr error) noexcept override;

 private:
  using Lock = std::unique_lock<std::mutex>;
  using Direction = Transfer::Direction;
  using State = Frame::State;
  using Standing = Frame::Standing;

  /// Adds the time from construction to destruction to the waits of one direction, for a session.
  class Wait;

  // pager_frames.cpp
  /// A frame for the block, pinned once, or nullptr if it had to let go of the lock on the way:
  /// somebody else may have brought the block in.
  Frame* claim(Lock& lock, SessionState& session, const LevelFile& level, std::uint64_t block);
  /// A frame from what is free, or nullptr. Errors: those of Backend::address; std::bad_alloc.
  Frame* take_frame(SessionState& session, const LevelFile& level, std::uint64_t block);
  /// Frees a frame, or waits until that may be tried again. False: it let go of the lock.
  bool make_room(Lock& lock, SessionState& session, const LevelFile& wanted_by,
                 std::uint64_t wanted_bytes);
  /// Whether some pin may end while this thread waits (plait/session.h has the rule).
  bool may_come_free(const SessionState& session) const noexcept;
  void wait_for_room(Lock& lock, SessionState& session) noexcept;
  std::uint64_t share_bytes(const SessionState& session) const noexcept;
  /// What a session has beyond its share; negative if that is not used up.
  std::int64_t excess_bytes(const SessionState& session) const noexcept;
  /// The session that is furthest over its share of those that `has` something; `asking` counts
  /// with the frame that it asks for. nullptr: none has.
  template <class Has>
  SessionState* furthest_over(const SessionState& asking, std::uint64_t wanted_bytes,
                              Has has) noexcept;
  /// The next to be evicted, or nullptr.
  Frame* victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  Frame* clean_victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  /// The announced block that is needed last, or nullptr.
  Frame* last_announced(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  /// A frame that can be had without writing, or nullptr.
  Frame* take_clean_frame(SessionState& session, const LevelFile& level,
                          std::uint64_t block) noexcept;
  void give(Frame& frame, SessionState* session) noexcept;
  void evict(Frame& frame) noexcept;
  /// Tells backends that map what was evicted, and lets go of the lock for it.
  void tell_evicted(Lock& lock) noexcept;
  /// The block leaves the memory.
  void drop(Frame& frame) noexcept;
  void vacate(Frame& frame) noexcept;
  /// The last pin or transfer of a frame ended: where does it go?
  void settle(Frame& frame) noexcept;
  void stand(Frame& frame, Standing standing, EdgeId order) noexcept;
  /// The frame is about to be used: takes it out of where settle() put it.
  void unsettle(Frame& frame) noexcept;
  void announce(Frame& frame) noexcept;
  void unannounce(Frame& frame) noexcept;

  // pager_transfers.cpp
  void bring_in(Lock& lock, SessionState& session, Frame& frame, Access access);
  void start(Lock& lock, Frame& frame) noexcept;
  /// `session`: whose wait it is; nullptr: nobody's.
  void wait(Lock& lock, SessionState* session, Direction direction) noexcept;
  void wait_for(Lock& lock, SessionState& session, Frame& frame) noexcept;
  void wait_for_change(Lock& lock, std::uint64_t since) noexcept {
    changed_.wait(lock, [&] { return changes_ != since; });
  }
  void tell_of_change() noexcept;
  void begin_write(Frame& frame) noexcept;
  /// What writing a block in memory amounts to.
  void mark_written(Frame& frame) noexcept;
  void write_here(Lock& lock, SessionState* session, Frame& frame);
  void write_behind() noexcept;
  /// Takes back what is queued for this level, or for all if nullptr, and waits for the rest.
  void stop_transfers(Lock& lock, const LevelFile* level) noexcept;
  void fail(std::exception_ptr error) noexcept;
  [[noreturn]] void refuse(std::string_view what);
  void count_transfer(const Frame& frame, Direction direction) noexcept;

  bool writes_behind(const SessionState* session) const {
    return queue_.has_threads() && session && session->options.policy == EvictionPolicy::kWindow;
  }
  static bool is_memory(const LevelFile& level) { return level.traits.in_memory; }
  static bool was_written(const LevelFile& level, std::uint64_t block) {
    return level.table[block].encoding != BlockEncoding::kNeverWritten;
  }
  Frame* frame_of(const LevelFile& level, std::uint64_t block) noexcept {
    const std::uint32_t index = resident_[level.pager_slot][block];
    return index == kNoId ? nullptr : &frames_[index];
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;  ///< some transfer ended
  std::uint64_t changes_ = 0;

  FramePool pool_;
  PagingStatistics statistics_;
  std::deque<Frame> frames_;  ///< a deque, because frames stay where they are
  FrameQueue vacant_;
  FrameQueue to_write_;  ///< oldest first
  FrameQueue leaving_;   ///< evicted, for tell_evicted()
  FrameQueue left_;      ///< by sessions that ended, oldest first
  SessionList sessions_;
  struct Waiter : boost::intrusive::list_base_hook<> {
    std::thread::id thread = std::this_thread::get_id();
  };
  boost::intrusive::list<Waiter> waiters_;  ///< threads that wait for a frame, on their stacks
  std::vector<std::vector<std::uint32_t>> resident_;  ///< [pager slot][block] frame or kNoId
  std::vector<std::uint32_t> vacant_slots_;           ///< has room for all of them
  std::uint32_t reads_under_way_ = 0;                 ///< for pins, and ahead of them
  std::uint32_t reads_ahead_ = 0, writes_in_flight_ = 0;
  bool failed_ = false;
  std::exception_ptr failure_;  ///< not reported yet

  IoQueue queue_;  ///< last: its threads end first
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
