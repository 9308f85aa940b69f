#include "paging/io_queue.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/threads.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

void IoQueue::submit(QueuedTransfer& transfer) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    queue_.push_back(transfer);
  }
  queued_.notify_one();
}

bool IoQueue::withdraw(QueuedTransfer& transfer) noexcept {
  const std::scoped_lock lock(mutex_);
  if (!transfer.in_queue.is_linked()) return false;
  queue_.erase(queue_.iterator_to(transfer));
  return true;
}

bool IoQueue::begin_oldest(Transfer::Direction direction) noexcept {
  QueuedTransfer* transfer = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    const auto oldest = std::ranges::find_if(
        queue_, [&](const QueuedTransfer& queued) { return queued.direction == direction; });
    if (oldest == queue_.end()) return false;
    transfer = &*oldest;
    queue_.erase(oldest);
  }
  transfer->backend->start(*transfer);
  return true;
}

void IoQueue::work() noexcept {
  std::unique_lock lock(mutex_);
  while (true) {
    queued_.wait(lock, [&] { return ending_ || !queue_.empty(); });
    if (queue_.empty()) return;
    QueuedTransfer& transfer = queue_.front();
    queue_.pop_front();
    lock.unlock();
    transfer.backend->start(transfer);
    lock.lock();
  }
}

PLAIT_END_NAMESPACE
