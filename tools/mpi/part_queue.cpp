#include "mpi/part_queue.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace plait::mpi {

std::optional<std::uint32_t> PartQueue::next() {
  const std::scoped_lock lock(mutex_);
  if (stopped_ || next_ == parts_) return std::nullopt;
  return next_++;
}

void PartQueue::end(std::uint32_t part, PartOutcome outcome) {
  const std::scoped_lock lock(mutex_);
  ++counts_[static_cast<std::size_t>(outcome)];
  if (outcome == PartOutcome::kFailed || outcome == PartOutcome::kCancelled)
    not_done_.push_back(part);
}

void PartQueue::stop() {
  const std::scoped_lock lock(mutex_);
  stopped_ = true;
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
  std::ranges::sort(parts);
  for (std::uint32_t part = next_; part < parts_; ++part) parts.push_back(part);
  return parts;
}

}  // namespace plait::mpi
