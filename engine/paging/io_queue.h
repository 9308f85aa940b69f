// Transfers that happen behind the caller's back, oldest first.
#pragma once

#include <boost/intrusive/list.hpp>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "plait/backend.h"

namespace plait {

/// A transfer with its place in the queue: to queue it allocates nothing.
struct QueuedTransfer : Transfer {
  Backend* backend = nullptr;
  boost::intrusive::list_member_hook<> in_queue;
};

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
  /// Errors: kOutOfMemory for want of a thread.
  void start_threads();

  /// Backend and transfer stay until the listener was told. REQUIRES: the threads run.
  void submit(QueuedTransfer& transfer) noexcept;
  /// Takes a transfer back. False: it was begun, and its listener will be told.
  bool withdraw(QueuedTransfer& transfer) noexcept;
  /// Begins the oldest queued transfer of this direction in the caller's thread: whoever would have
  /// to wait for it can as well do it. False: there is none.
  bool begin_oldest(Transfer::Direction direction) noexcept;

 private:
  using Queue = boost::intrusive::list<
      QueuedTransfer,
      boost::intrusive::member_hook<QueuedTransfer, boost::intrusive::list_member_hook<>,
                                    &QueuedTransfer::in_queue>>;
  void work() noexcept;

  int thread_count_;
  std::mutex mutex_;
  std::condition_variable queued_;
  Queue queue_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace plait
