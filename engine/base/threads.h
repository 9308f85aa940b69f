// base/threads.h: starts threads. Threads of the library run no signal handler of the program: they
// block all signals but those of faults of their own, so the kernel gives the program's signals to
// threads of the program.
#pragma once

#include <signal.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/interruption.h"
#include "plait/detail/namespace.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

/// Blocks, in the calling thread, all signals but those that the kernel sends for a fault of the
/// thread itself, and restores its mask at the end. A new thread has the mask of the thread that
/// starts it.
class SignalsHeld {
 public:
  SignalsHeld() noexcept;
  ~SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  friend class SignalsTaken;
  sigset_t before_{};
  SignalsHeld* outer_ = nullptr;  ///< of the same thread
};

/// Inside a SignalsHeld of the calling thread: restores the mask from before it, and blocks again
/// at the end. In other threads it does nothing.
class SignalsTaken {
 public:
  SignalsTaken() noexcept;
  ~SignalsTaken();
  SignalsTaken(const SignalsTaken&) = delete;
  SignalsTaken& operator=(const SignalsTaken&) = delete;

 private:
  SignalsHeld* held_ = nullptr;
  sigset_t blocked_{};
};

/// Starts a thread that calls `work`. `what` names the thread in the message ("I/O thread 2 of 4").
/// Errors: kOutOfMemory if the system allows no further thread.
std::thread start_thread(std::string_view what, std::function<void()> work);

/// The error of a thread that could not be started.
[[noreturn]] void refuse_thread(std::string_view what, std::string_view reason);

/// The next smaller number of threads to try when the memory of more does not fit.
constexpr int fewer_threads(int threads) noexcept {
  return std::max(1, threads - std::max(1, threads / 4));
}

/// Joins its threads when it ends.
class JoinedThreads {
 public:
  JoinedThreads() = default;
  ~JoinedThreads() {
    for (std::thread& thread : threads_) thread.join();
  }
  JoinedThreads(const JoinedThreads&) = delete;
  JoinedThreads& operator=(const JoinedThreads&) = delete;

  /// Errors: as start_thread().
  void start(std::string_view what, std::function<void()> work) {
    threads_.reserve(threads_.size() + 1);
    threads_.push_back(start_thread(what, std::move(work)));
  }

 private:
  std::vector<std::thread> threads_;
};

/// Runs a loop of TBB, and returns what it returns. Every loop of the library runs in this call.
/// The calling thread blocks signals meanwhile, because a thread that TBB starts has the mask of
/// the thread that starts it. Signals that are for the calling thread wait for its next body of
/// each_on_workers() or ranges_on_workers(), or for the end of the loop.
/// Errors: those of the loop; kOutOfMemory if TBB cannot start a thread.
template <class Loop>
auto on_workers(Loop loop) {
  try {
    const SignalsHeld held;
    return loop();
  } catch (const std::system_error& failure) {
    refuse_thread("a thread of TBB", failure.what());
  } catch (const std::runtime_error& failure) {
    if (std::string_view(failure.what()).find("pthread_create") == std::string_view::npos) throw;
    refuse_thread("a thread of TBB", failure.what());
  }
}

/// Calls body(i) for all i from `first` to before `last`, on the threads of the calling thread's
/// arena. Errors: as on_workers().
template <class Index, class Body>
void each_on_workers(Index first, Index last, const Body& body) {
  on_workers([&] {
    tbb::parallel_for(first, last, [&, asked = Interruptible::current()](Index i) {
      const SignalsTaken taken;
      const InterruptibleWorker worker(asked);
      body(i);
    });
  });
}

/// Calls body(first, last) for ranges that cover [0, count). A range of `grain` elements or fewer
/// is not divided further. Errors: as on_workers().
template <class Body>
void ranges_on_workers(std::size_t count, std::size_t grain, const Body& body) {
  using Range = tbb::blocked_range<std::size_t>;
  on_workers([&] {
    tbb::parallel_for(Range(0, count, grain),
                      [&, asked = Interruptible::current()](const Range& range) {
                        const SignalsTaken taken;
                        const InterruptibleWorker worker(asked);
                        body(range.begin(), range.end());
                      });
  });
}

PLAIT_END_NAMESPACE

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls work(0) to work(count - 1) by `parallel_for`, and throws the first exception of any of
/// them. Workers take what they do from a queue, so it does not matter how many threads there are.
/// `name` begins the message. Errors: also kBadState unless `parallel_for` keeps its promise.
void call_workers(const ParallelFor& parallel_for, int count, std::string_view name,
                  const std::function<void(int)>& work);

PLAIT_END_NAMESPACE
