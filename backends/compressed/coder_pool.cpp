#include "compressed/coder_pool.h"

#include <algorithm>
#include <utility>

namespace plait {

CoderPool::CoderPool(const VolumeSpec& volume) : volume_(volume) {
  idle_.reserve(static_cast<std::size_t>(std::max(1, volume.threads)));
}

std::uint64_t CoderPool::largest_coder_bytes(std::uint64_t raw_bytes) const {
  std::uint64_t bytes = 1;
  for (const std::string& pipeline : pipelines_)
    bytes = std::max(bytes, BlockCoder(pipeline, 4, raw_bytes).memory_bytes());
  return bytes;
}

void CoderPool::make_room_for(const std::string& pipeline, std::uint64_t raw_bytes) {
  const BlockCoder refuses_what_is_no_pipeline(pipeline, 4, raw_bytes);
  const std::scoped_lock lock(mutex_);
  const bool is_known = !pipelines_.insert(pipeline).second;
  if (is_known && raw_bytes <= max_raw_bytes_) return;
  raw_bytes = std::max(raw_bytes, max_raw_bytes_);
  if (raw_bytes > max_raw_bytes_) idle_.clear();
  max_raw_bytes_ = raw_bytes;
  coder_bytes_ = largest_coder_bytes(raw_bytes);
  const auto threads = static_cast<std::size_t>(std::max(1, volume_.threads));
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

std::unique_ptr<BlockCoder> CoderPool::take(const std::string& pipeline,
                                            std::size_t component_bytes) {
  std::unique_ptr<BlockCoder> coder;
  std::uint64_t max_raw_bytes = 0;
  {
    std::unique_lock lock(mutex_);
    given_back_.wait(lock, [&] { return taken_ < most_coders_; });
    ++taken_;
    max_raw_bytes = max_raw_bytes_;
    if (!idle_.empty()) {
      // A coder of the same pipeline has its codec's memory set up.
      const auto same = std::ranges::find_if(
          idle_, [&](const auto& idle) { return idle->pipeline() == pipeline; });
      if (same != idle_.end()) std::swap(idle_.back(), *same);
      if (same != idle_.end() || taken_ + idle_.size() > most_coders_) {
        coder = std::move(idle_.back());
        idle_.pop_back();
      }
    }
  }
  try {
    if (!coder) coder = std::make_unique<BlockCoder>(pipeline, component_bytes, max_raw_bytes);
    coder->set_pipeline(pipeline, component_bytes);
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
