// Transfers that happen behind the caller's back, oldest first.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "plait/backend.h"

namespace plait {

/// Threads that hand queued transfers to their backends. Safe from any thread; no call takes a lock
/// of the listener's but begin_oldest().
class IoQueue {
 public:
  explicit IoQueue(int threads) : thread_count_(threads) {}
  /// REQUIRES: nothing is queued.
  ~IoQueue();
  IoQueue(const IoQueue&) = delete;
  IoQueue& operator=(const IoQueue&) = delete;

  bool has_threads() const { return thread_count_ > 0; }

  /// Starts the threads unless they run: a store in memory never needs them. One thread at a time.
  /// Errors: std::system_error.
  void start_threads();

  /// Backend and transfer stay until the listener was told. REQUIRES: the threads run.
  void submit(Backend& backend, Transfer& transfer);
  /// Takes a transfer back. False: it was begun, and its listener will be told.
  bool withdraw(const Transfer& transfer);
  /// Begins the oldest queued transfer of this direction in the caller's thread: whoever would have
  /// to wait for it can as well do it. False: there is none.
  bool begin_oldest(Transfer::Direction direction);

 private:
  struct Job {
    Backend* backend;
    Transfer* transfer;
  };
  void work();

  int thread_count_;
  std::mutex mutex_;
  std::condition_variable queued_;
  std::deque<Job> jobs_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace plait
