#include "paging/io_queue.h"

#include <algorithm>

namespace plait {

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
    threads_.emplace_back([this] { work(); });
}

void IoQueue::submit(Backend& backend, Transfer& transfer) {
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back({&backend, &transfer});
  }
  queued_.notify_one();
}

bool IoQueue::withdraw(const Transfer& transfer) {
  const std::scoped_lock lock(mutex_);
  return std::erase_if(jobs_, [&](const Job& job) { return job.transfer == &transfer; }) > 0;
}

bool IoQueue::begin_oldest(Transfer::Direction direction) {
  Job job{};
  {
    const std::scoped_lock lock(mutex_);
    const auto oldest = std::ranges::find_if(
        jobs_, [&](const Job& queued) { return queued.transfer->direction == direction; });
    if (oldest == jobs_.end()) return false;
    job = *oldest;
    jobs_.erase(oldest);
  }
  job.backend->start(*job.transfer);
  return true;
}

void IoQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    queued_.wait(lock, [&] { return ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const Job job = jobs_.front();
    jobs_.pop_front();
    lock.unlock();
    job.backend->start(*job.transfer);
    lock.lock();
  }
}

}  // namespace plait
