// A queue of transfers that I/O threads carry out, oldest first. This is the one place where
// transfers of adjacent blocks are joined: what lies side by side in the queue begins together.
#pragma once

#include <boost/container/static_vector.hpp>
#include <boost/intrusive/list.hpp>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A transfer with its link in the queue, so that queueing it allocates no memory.
struct QueuedTransfer : Transfer {
  Backend* backend = nullptr;
  int run_log2 = 0;  ///< of its level
  boost::intrusive::list_member_hook<> in_queue;
};

/// Whether the block of `after` moves in one run with that of `before`, behind it.
bool follows(const QueuedTransfer& before, const QueuedTransfer& after) noexcept;

/// Transfers that begin together. REQUIRES: each follows the one before it.
class TransferRun {
 public:
  TransferRun() = default;
  explicit TransferRun(QueuedTransfer& only) noexcept { add(only); }
  void add(QueuedTransfer& transfer) noexcept { transfers_.push_back(&transfer); }
  bool empty() const noexcept { return transfers_.empty(); }
  std::span<QueuedTransfer* const> transfers() const noexcept {
    return {transfers_.data(), transfers_.size()};
  }
  /// Begins them in this thread. REQUIRES: it is not empty.
  void start() const noexcept;

 private:
  boost::container::static_vector<QueuedTransfer*, kMostRunBlocks> transfers_;
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

  /// Queues transfers, one after another. Backend and transfers must exist until the listener is
  /// called. REQUIRES: the threads run.
  void submit(const TransferRun& run) noexcept;
  /// Removes a transfer from the queue. Returns false if it has begun; then its listener will be
  /// called.
  bool withdraw(QueuedTransfer& transfer) noexcept;
  /// Begins a transfer in the calling thread, which would otherwise only wait for it, together with
  /// those that it is queued side by side with. Returns false if it has begun.
  bool begin(QueuedTransfer& transfer) noexcept;
  /// The same for the oldest queued transfer of this direction. Returns false if the queue has
  /// none.
  bool begin_oldest(Transfer::Direction direction) noexcept;

 private:
  using Queue = boost::intrusive::list<
      QueuedTransfer,
      boost::intrusive::member_hook<QueuedTransfer, boost::intrusive::list_member_hook<>,
                                    &QueuedTransfer::in_queue>>;
  /// Takes a transfer off the queue, with its neighbours. REQUIRES: the caller has the lock.
  TransferRun take(const Queue::iterator& at) noexcept;
  void work() noexcept;

  int thread_count_;
  std::mutex mutex_;
  std::condition_variable queued_;
  Queue queue_;
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

PLAIT_END_NAMESPACE
