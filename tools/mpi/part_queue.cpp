#include "mpi/part_queue.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace plait::mpi {

/// REQUIRES: the lock.
std::optional<std::uint32_t> PartQueue::next_of(int rank) {
  if (stopped_) return std::nullopt;
  if (next_ < parts_) {
    ++running_;
    return next_++;
  }
  const auto failed =
      std::ranges::find_if(again_, [&](const Failure& failure) { return failure.rank != rank; });
  if (failed == again_.end()) return std::nullopt;
  const std::uint32_t part = failed->part;
  again_.erase(failed);
  retried_.push_back(part);
  ++running_;
  return part;
}

std::optional<std::uint32_t> PartQueue::next(int rank) {
  const std::scoped_lock lock(mutex_);
  return next_of(rank);
}

std::optional<std::uint32_t> PartQueue::wait_for_next(int rank) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (const std::optional<std::uint32_t> part = next_of(rank)) return part;
    if (stopped_ || running_ == 0) return std::nullopt;
    ended_.wait(lock);
  }
}

void PartQueue::end(std::uint32_t part, int rank, PartOutcome outcome) {
  const std::scoped_lock lock(mutex_);
  --running_;
  ended_.notify_all();
  if (outcome == PartOutcome::kFailed && std::ranges::find(retried_, part) == retried_.end()) {
    again_.push_back({part, rank});
    return;
  }
  ++counts_[static_cast<std::size_t>(outcome)];
  if (outcome == PartOutcome::kFailed || outcome == PartOutcome::kCancelled)
    not_done_.push_back(part);
}

void PartQueue::stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
  ended_.notify_all();
}

std::uint32_t PartQueue::ended() const {
  const std::scoped_lock lock(mutex_);
  return std::accumulate(std::begin(counts_), std::end(counts_), 0u);
}

std::uint32_t PartQueue::count(PartOutcome outcome) const {
  const std::scoped_lock lock(mutex_);
  return counts_[static_cast<std::size_t>(outcome)];
}

std::vector<std::uint32_t> PartQueue::not_done() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::uint32_t> parts = not_done_;
  for (const Failure& failure : again_) parts.push_back(failure.part);
  std::ranges::sort(parts);
  for (std::uint32_t part = next_; part < parts_; ++part) parts.push_back(part);
  return parts;
}

}  // namespace plait::mpi
