// The pager's data of one session: its frames, in the order in which its policy evicts them, and
// the threads that pinned blocks in it.
#pragma once

#include <boost/intrusive/list.hpp>
#include <cstdint>
#include <thread>
#include <vector>

#include "paging/eviction.h"
#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager's lock protects it.
class SessionState {
 public:
  /// A thread, and the number of pins that it made and that have not ended. Another thread may end
  /// them.
  struct Caller {
    std::thread::id thread;
    std::uint32_t pins = 0;
  };

  SessionState(Pager::Implementation* its_pager, const SessionOptions& its_options)
      : pager(its_pager), options(its_options) {}
  SessionState(const SessionState&) = delete;
  SessionState& operator=(const SessionState&) = delete;

  Eviction& eviction() {
    return options.policy == EvictionPolicy::kClock ? static_cast<Eviction&>(clock_) : window_;
  }

  /// The calling thread's number among the callers. Errors: std::bad_alloc.
  std::uint32_t caller();
  void add_pin(std::uint32_t caller) noexcept {
    ++pins_;
    ++callers_[caller].pins;
  }
  void end_pin(std::uint32_t caller) noexcept {
    --pins_;
    --callers_[caller].pins;
  }
  std::uint32_t pins() const { return pins_; }
  const std::vector<Caller>& callers() const { return callers_; }

  Pager::Implementation* const pager;
  const SessionOptions options;
  PagingStatistics statistics;
  std::uint64_t frame_bytes = 0;              ///< of its frames
  std::uint64_t announced_bytes = 0;          ///< of its prefetched frames that are not pinned yet
  std::uint32_t waiting = 0;                  ///< threads that wait for a frame
  bool ended = false;                         ///< then this object exists until its last pin ends
  SessionFrames frames;                       ///< all frames of the session
  FrameOrder ahead;                           ///< prefetched, not pinned; needed in this order
  boost::intrusive::list_member_hook<> link;  ///< in Sessions

 private:
  WindowEviction window_;
  ClockEviction clock_;
  std::uint32_t pins_ = 0;
  std::vector<Caller> callers_;
};

PLAIT_END_NAMESPACE
