// A queue of transfers that I/O threads carry out, oldest first.
#pragma once

#include <boost/intrusive/list.hpp>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A transfer with its link in the queue, so that queueing it allocates no memory.
struct QueuedTransfer : Transfer {
  Backend* backend = nullptr;
  boost::intrusive::list_member_hook<> in_queue;
};

/// Threads that pass queued transfers to their backends. Safe from any thread. Only begin_oldest()
/// may call the listener, and so take a lock of the listener.
class IoQueue {
 public:
  explicit IoQueue(int threads) : thread_count_(threads) {}
  /// REQUIRES: the queue is empty.
  ~IoQueue();
  IoQueue(const IoQueue&) = delete;
  IoQueue& operator=(const IoQueue&) = delete;

  bool has_threads() const { return thread_count_ > 0; }

  /// Starts the threads, unless they run. (A store in memory never needs them.) Only one thread at
  /// a time may call it. Errors: kOutOfMemory if a thread cannot be started.
  void start_threads();

  /// Queues a transfer. Backend and transfer must exist until the listener is called. REQUIRES: the
  /// threads run.
  void submit(QueuedTransfer& transfer) noexcept;
  /// Removes a transfer from the queue. Returns false if it has begun; then its listener will be
  /// called.
  bool withdraw(QueuedTransfer& transfer) noexcept;
  /// Begins the oldest queued transfer of this direction in the calling thread, which would
  /// otherwise only wait for it. Returns false if the queue has none.
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

PLAIT_END_NAMESPACE
