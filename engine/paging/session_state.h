// The pager's data of one session: its frames, in the order in which its policy evicts them, and
// the threads that pinned blocks in it.
#pragma once

#include <boost/intrusive/list.hpp>
#include <cstdint>

#include "paging/eviction.h"
#include "paging/session_callers.h"
#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager's lock protects everything except `callers`.
class SessionState {
 public:
  SessionState(Pager::Implementation* its_pager, const SessionOptions& its_options)
      : pager(its_pager), options(its_options) {}
  SessionState(const SessionState&) = delete;
  SessionState& operator=(const SessionState&) = delete;

  Eviction& eviction() {
    return options.policy == EvictionPolicy::kClock ? static_cast<Eviction&>(clock_) : window_;
  }

  Pager::Implementation* const pager;
  const SessionOptions options;
  SessionCallers callers;
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
};

PLAIT_END_NAMESPACE
