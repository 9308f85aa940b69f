// What the pager knows of a session: its frames, in the order in which its policy gives them up,
// and who calls it. Under the pager's lock.
#pragma once

#include <boost/intrusive/list.hpp>
#include <cstdint>
#include <thread>
#include <vector>

#include "paging/eviction.h"
#include "plait/pager.h"

namespace plait {

class SessionState {
 public:
  /// A thread that pinned something.
  struct Caller {
    std::thread::id thread;
    std::uint32_t pins = 0;
  };

  SessionState(Pager::Implementation& its_pager, const SessionOptions& its_options)
      : pager(its_pager), options(its_options) {
    callers.reserve(4);
  }
  SessionState(const SessionState&) = delete;
  SessionState& operator=(const SessionState&) = delete;

  Eviction& eviction() {
    return options.policy == EvictionPolicy::kClock ? static_cast<Eviction&>(clock_) : window_;
  }
  /// The calling thread's entry. Errors: std::bad_alloc.
  std::uint32_t caller() {
    const std::thread::id thread = std::this_thread::get_id();
    std::uint32_t vacant = 0;
    for (std::uint32_t i = 0; i < callers.size(); ++i)
      if (callers[i].thread == thread) return i;
    while (vacant < callers.size() && callers[vacant].pins > 0) ++vacant;
    if (vacant == callers.size()) callers.emplace_back();
    callers[vacant].thread = thread;
    return vacant;
  }

  Pager::Implementation& pager;
  const SessionOptions options;
  PagingStatistics statistics;
  std::uint64_t frame_bytes = 0;  ///< of its frames
  std::uint64_t announced_bytes = 0;
  std::uint32_t pins = 0;
  std::uint32_t waiting = 0;  ///< threads that wait for a frame
  bool ended = false;         ///< lives on until its last pin ends
  std::vector<Caller> callers;
  FrameOrder ahead;                           ///< announced; the last are needed last
  SessionFrames frames;                       ///< all that belong to it
  boost::intrusive::list_member_hook<> link;  ///< among the pager's sessions

 private:
  WindowEviction window_;
  ClockEviction clock_;
};

using SessionList = boost::intrusive::list<
    SessionState, boost::intrusive::member_hook<SessionState, boost::intrusive::list_member_hook<>,
                                                &SessionState::link>>;

}  // namespace plait
