#include "compressed/coder_pool.h"

#include <algorithm>
#include <utility>

namespace plait {

CoderPool::CoderPool(const VolumeSpec& volume) : volume_(volume) { make_room_for(1); }

void CoderPool::make_room_for(std::uint64_t raw_bytes) {
  const std::scoped_lock lock(mutex_);
  if (raw_bytes <= max_raw_bytes_) return;
  const BlockCoder sample(volume_.options.codec, volume_.options.filter, 4, raw_bytes);
  const auto threads = static_cast<std::size_t>(std::max(1, volume_.threads));
  idle_.clear();
  idle_.reserve(threads);
  max_raw_bytes_ = raw_bytes;
  coder_bytes_ = std::max<std::uint64_t>(1, sample.memory_bytes());
  most_coders_ = static_cast<std::size_t>(
      std::clamp<std::uint64_t>(volume_.most_scratch_bytes / coder_bytes_, 1, threads));
}

std::uint64_t CoderPool::memory_bytes() const noexcept {
  const std::scoped_lock lock(mutex_);
  return std::min(most_coders_ * coder_bytes_, volume_.most_scratch_bytes);
}

std::size_t CoderPool::most_coders() const noexcept {
  const std::scoped_lock lock(mutex_);
  return most_coders_;
}

void CoderPool::shrink() noexcept {
  const std::scoped_lock lock(mutex_);
  idle_.clear();
}

std::unique_ptr<BlockCoder> CoderPool::take(std::size_t component_bytes) {
  std::unique_ptr<BlockCoder> coder;
  std::uint64_t max_raw_bytes = 0;
  {
    std::unique_lock lock(mutex_);
    given_back_.wait(lock, [&] { return taken_ < most_coders_; });
    ++taken_;
    max_raw_bytes = max_raw_bytes_;
    if (!idle_.empty()) {
      coder = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  try {
    if (!coder)
      coder = std::make_unique<BlockCoder>(volume_.options.codec, volume_.options.filter,
                                           component_bytes, max_raw_bytes);
    coder->set_component_bytes(component_bytes);
    return coder;
  } catch (...) {
    give_back(nullptr);
    throw;
  }
}

void CoderPool::give_back(std::unique_ptr<BlockCoder> coder) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    --taken_;
    if (coder && coder->max_raw_bytes() == max_raw_bytes_ && idle_.size() < most_coders_)
      idle_.push_back(std::move(coder));
  }
  given_back_.notify_one();
}

}  // namespace plait
