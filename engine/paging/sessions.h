// Decides which session's frame is evicted next, and which waits can end, by the rules of
// plait/extend/session.h. This class does not use transfers or memory.
#pragma once

#include <atomic>
#include <boost/intrusive/list.hpp>
#include <cstdint>

#include "base/contention.h"
#include "paging/frame_pool.h"
#include "paging/session_state.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The open sessions. The pager's lock protects everything except anybody_waits().
class Sessions {
 public:
  /// Marks the calling thread as waiting for a frame, from construction to destruction.
  class Waiter : public boost::intrusive::list_base_hook<> {
   public:
    Waiter(Sessions& sessions, SessionState& session) noexcept;
    ~Waiter();
    Waiter(const Waiter&) = delete;
    Waiter& operator=(const Waiter&) = delete;

   private:
    friend class Sessions;
    Sessions& sessions_;
    SessionState& session_;
    std::uint32_t thread_ = this_thread_number();
  };

  explicit Sessions(const FramePool& pool) : pool_(pool) {}
  Sessions(const Sessions&) = delete;
  Sessions& operator=(const Sessions&) = delete;

  void add(SessionState& session) noexcept { open_.push_back(session); }
  /// Ends a session. The pager will evict the frames that it leaves in the order of its policy.
  void end(SessionState& session) noexcept;

  /// Gives the frame to this session (nullptr: to none). The frame is then no longer marked as
  /// prefetched, and it cannot be evicted until place() is called.
  void give(Frame& frame, SessionState* session) noexcept;
  /// Marks the frame as prefetched. REQUIRES: the frame belongs to a session.
  void announce(Frame& frame) noexcept;
  /// Takes the mark away.
  void withdraw(Frame& frame) noexcept;
  /// The frame cannot be evicted until place() is called.
  static void unplace(Frame& frame) noexcept;
  static bool is_placed(const Frame& frame) noexcept {
    return frame.in_list.is_linked() || frame.in_order.is_linked();
  }
  /// The frame can be evicted after this call. REQUIRES: it is not placed, it is closed and has no
  /// pins.
  void place(Frame& frame) noexcept;

  /// The frame to evict next if the session `asking` wants a frame of `wanted_bytes`, or nullptr.
  /// Never a prefetched frame that is not pinned yet.
  Frame* victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  /// The prefetched frame to evict if no other frame can be freed, or nullptr.
  Frame* last_announced(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;

  std::uint64_t share_bytes(const SessionState& session) const noexcept;
  /// Whether a pin of another session may end while the calling thread waits. A thread that will
  /// wait becomes a Waiter first: then either this function sees that a pin has ended, or the
  /// thread that ends it sees the waiter.
  bool may_come_free(const SessionState& asking) const noexcept;
  /// Safe without the lock, after the end of a pin.
  bool anybody_waits() const noexcept { return waiter_count_ > 0; }

 private:
  template <class Has>
  SessionState* furthest_over(const SessionState& asking, std::uint64_t wanted_bytes,
                              Has has) noexcept;
  bool waits(std::uint32_t thread) const noexcept;

  using SessionList = boost::intrusive::list<
      SessionState, boost::intrusive::member_hook<
                        SessionState, boost::intrusive::list_member_hook<>, &SessionState::link>>;

  const FramePool& pool_;  ///< has the budget that the sessions share
  SessionList open_;
  FrameList left_;  ///< frames of ended sessions, oldest first
  boost::intrusive::list<Waiter> waiters_;
  std::atomic<std::uint32_t> waiter_count_ = 0;
};

PLAIT_END_NAMESPACE
