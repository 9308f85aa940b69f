// Whose frame goes next, and who waits for whom: the rules that plait/session.h promises. Knows
// neither transfers nor memory.
#pragma once

#include <boost/intrusive/list.hpp>
#include <cstdint>
#include <thread>

#include "paging/frame_pool.h"
#include "paging/session_state.h"

namespace plait {

/// The open sessions. One thread at a time (the pager's lock).
class Sessions {
 public:
  /// A thread that waits for a frame; lives on its stack, from construction to destruction.
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
    std::thread::id thread_ = std::this_thread::get_id();
  };

  explicit Sessions(const FramePool& pool) : pool_(pool) {}
  Sessions(const Sessions&) = delete;
  Sessions& operator=(const Sessions&) = delete;

  void add(SessionState& session) noexcept { open_.push_back(session); }
  /// What its policy would have given up first is the first of what it leaves.
  void end(SessionState& session) noexcept;

  /// The frame belongs to this session from now on; nullptr: to none. Ends an announcement, and the
  /// frame may not be evicted until it is placed again.
  void give(Frame& frame, SessionState* session) noexcept;
  /// REQUIRES: the frame belongs to a session.
  void announce(Frame& frame) noexcept;
  /// The frame is about to be used: it may not be evicted until it is placed again.
  static void unplace(Frame& frame) noexcept;
  static bool is_placed(const Frame& frame) noexcept {
    return frame.in_list.is_linked() || frame.in_order.is_linked();
  }
  /// The frame may be evicted from now on. REQUIRES: it is not placed.
  void place(Frame& frame) noexcept;

  /// The next to be evicted for a session that asks for a frame of so many bytes, or nullptr. What
  /// was announced is never among these.
  Frame* victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;
  /// The announced block that is to go if nothing else can, or nullptr.
  Frame* last_announced(const SessionState& asking, std::uint64_t wanted_bytes) noexcept;

  std::uint64_t share_bytes(const SessionState& session) const noexcept;
  /// Whether a pin of another session may end while the calling thread waits.
  bool may_come_free(const SessionState& asking) const noexcept;
  bool anybody_waits() const noexcept { return !waiters_.empty(); }

 private:
  template <class Has>
  SessionState* furthest_over(const SessionState& asking, std::uint64_t wanted_bytes,
                              Has has) noexcept;
  bool waits(std::thread::id thread) const noexcept;

  using SessionList = boost::intrusive::list<
      SessionState, boost::intrusive::member_hook<
                        SessionState, boost::intrusive::list_member_hook<>, &SessionState::link>>;

  const FramePool& pool_;  ///< whose budget is shared
  SessionList open_;
  FrameList left_;  ///< by sessions that ended, oldest first
  boost::intrusive::list<Waiter> waiters_;
};

}  // namespace plait
