// plait/progress.h: what a program hears of long calls and of its stores, and the threads that it
// lends them.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// How far a call is.
struct Progress {
  std::string_view phase = {};  ///< "level 3: odd vertices"; valid during the callback
  /// Of the whole call, unless its comment says otherwise. The call's comment names their unit.
  std::uint64_t done = 0, total = 0;
};

/// A call with such a callback calls it many times, on the thread that made the call, or, if the
/// store has a parallel_for (plait/options.h), on one of its threads at a time. If it returns
/// false, the call ends with ErrorCode::kCancelled. It may be empty.
using ProgressCallback = std::function<bool(const Progress&)>;

/// The number of threads for an option `threads`: 0 stands for the processors that this process may
/// use. `work` begins the message. Errors: kInvalidArgument unless threads is 0 to 1024.
int thread_count(int threads, std::string_view work);

/// A parallel loop of the program's thread pool: calls body(0) to body(count - 1), each once, and
/// returns when all have returned. It may call them in any order and on any number of threads, one
/// included, and the calling thread may be one of them. The results do not depend on that.
///
/// - No body waits for one that has not begun. It may wait for one that has: so each begun body
///   has a thread to itself until it returns, and that thread does not begin another one inside it.
/// - No body throws. The call for which plait computes throws what a body found.
/// - `body` is valid until this function returns. All that bodies wrote must be visible then, as it
///   is after any join.
/// - If this function throws, no body may run any more. What it throws comes out of the call.
///
/// A function that calls a body twice, or leaves one out without an error, makes the call fail with
/// kBadState.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

/// Something that a store did. Texts are valid during the call.
struct StoreEvent {
  enum class Kind : std::uint8_t {
    kOpened,     ///< create() or open() has ended
    kCommitted,  ///< commit() has made a version
    kEvicted,    ///< a block left memory, because others needed its room
    kSlowRead,   ///< a block was read, and that took long
  };
  Kind kind = Kind::kOpened;
  std::string_view store = {};    ///< its path; empty for a store in memory
  std::uint64_t version = 0;      ///< opened, committed: Store::sequence()
  std::uint64_t duration_ns = 0;  ///< all but evicted; of a read, with its time in the queue
  // Evicted and slow read:
  std::string_view attribute = {};  ///< the name that it had when its level was opened
  int level = 0;
  std::uint64_t block = 0, bytes = 0;  ///< bytes before compression
};

/// Whom a store tells of events. Calls come from any thread that uses the store and from its I/O
/// threads, several at the same time, with no lock held. The call should return soon, because a
/// read waits for it. It may take the pager's statistics (StoreAccess::pager), and call no function
/// of the store. What it throws is lost. No call comes after close() has returned, nor after the
/// store and all its readers and views are gone. While readers or views live after the Store
/// object, calls may come that have no Store to ask.
struct StoreEvents {
  std::function<void(const StoreEvent&)> call = {};
  std::uint64_t slow_read_ns = 100'000'000;  ///< a read that takes longer is slow

  void tell(const StoreEvent& event) const noexcept {
    if (!call) return;
    try {
      call(event);
    } catch (...) {  // a log that fails must not make a read fail
    }
  }
};

PLAIT_END_NAMESPACE
