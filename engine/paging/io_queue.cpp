#include "paging/io_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/threads.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

bool follows(const QueuedTransfer& before, const QueuedTransfer& after) noexcept {
  return after.block == before.block + 1 && after.backend == before.backend &&
         after.block >> after.run_log2 == before.block >> before.run_log2;
}

void TransferRun::start() const noexcept {
  Backend& backend = *transfers_.front()->backend;
  if (transfers_.size() == 1) return backend.start(*transfers_.front());
  boost::container::static_vector<Transfer*, kMostRunBlocks> run(transfers_.begin(),
                                                                 transfers_.end());
  backend.start_run({run.data(), run.size()});
}

IoQueue::~IoQueue() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  queued_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void IoQueue::start_threads() {
  while (threads_.size() < static_cast<std::size_t>(thread_count_))
    threads_.push_back(
        start_thread(fmt::format("I/O thread {} of {}", threads_.size() + 1, thread_count_),
                     [this] { work(); }));
}

void IoQueue::submit(const TransferRun& run) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    for (QueuedTransfer* const transfer : run.transfers()) queue_.push_back(*transfer);
  }
  queued_.notify_one();
}

bool IoQueue::withdraw(QueuedTransfer& transfer) noexcept {
  const std::scoped_lock lock(mutex_);
  if (!transfer.in_queue.is_linked()) return false;
  queue_.erase(queue_.iterator_to(transfer));
  return true;
}

TransferRun IoQueue::take(const Queue::iterator& at) noexcept {
  const auto joins = [](const QueuedTransfer& before, const QueuedTransfer& after) {
    return before.direction == after.direction && follows(before, after);
  };
  auto first = at, after = std::next(at);
  while (first != queue_.begin() && joins(*std::prev(first), *first)) --first;
  while (after != queue_.end() && joins(*std::prev(after), *after)) ++after;
  TransferRun run;
  while (first != after) {
    run.add(*first);
    first = queue_.erase(first);
  }
  return run;
}

bool IoQueue::begin(QueuedTransfer& transfer) noexcept {
  TransferRun run;
  {
    const std::scoped_lock lock(mutex_);
    if (!transfer.in_queue.is_linked()) return false;
    run = take(queue_.iterator_to(transfer));
  }
  run.start();
  return true;
}

bool IoQueue::begin_oldest(Transfer::Direction direction) noexcept {
  TransferRun run;
  {
    const std::scoped_lock lock(mutex_);
    const auto oldest = std::ranges::find_if(
        queue_, [&](const QueuedTransfer& queued) { return queued.direction == direction; });
    if (oldest == queue_.end()) return false;
    run = take(oldest);
  }
  run.start();
  return true;
}

void IoQueue::work() noexcept {
  std::unique_lock lock(mutex_);
  while (true) {
    queued_.wait(lock, [&] { return ending_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const TransferRun run = take(queue_.begin());
    lock.unlock();
    run.start();
    lock.lock();
  }
}

PLAIT_END_NAMESPACE
