// base/threads.h: starts threads. Threads of the library run no signal handler of the program: they
// block all signals but those of faults of their own, so the kernel gives the program's signals to
// threads of the program.
#pragma once

#include <tbb/task_scheduler_observer.h>

#include <functional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Blocks, in the calling thread, all signals but those that the kernel sends for a fault of the
/// thread itself.
void block_signals() noexcept;

/// Starts a thread that calls `work`. `what` names the thread in the message ("I/O thread 2 of 4").
/// Errors: kOutOfMemory if the system allows no further thread.
std::thread start_thread(std::string_view what, std::function<void()> work);

/// The error of a thread that could not be started.
[[noreturn]] void refuse_thread(std::string_view what, std::string_view reason);

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

/// While this object exists, threads of TBB that work on loops of the calling thread's arena block
/// signals. They do so from then on.
class QuietWorkers final : public tbb::task_scheduler_observer {
 public:
  QuietWorkers() { observe(true); }
  ~QuietWorkers() override { observe(false); }
  QuietWorkers(const QuietWorkers&) = delete;
  QuietWorkers& operator=(const QuietWorkers&) = delete;

  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) block_signals();
  }
};

/// Runs a loop of TBB, and returns what it returns. Every loop of the library runs in this call.
/// Errors: those of the loop; kOutOfMemory if TBB cannot start a thread.
template <class Loop>
auto on_workers(Loop loop) {
  try {
    const QuietWorkers quiet;
    return loop();
  } catch (const std::system_error& failure) {
    refuse_thread("a thread of TBB", failure.what());
  } catch (const std::runtime_error& failure) {
    if (std::string_view(failure.what()).find("pthread_create") == std::string_view::npos) throw;
    refuse_thread("a thread of TBB", failure.what());
  }
}

PLAIT_END_NAMESPACE
