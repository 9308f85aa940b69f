#include "compressed/coder_pool.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

CoderPool::CoderPool(const PipelineRegistry& pipelines, const VolumeSpec& volume)
    : pipelines_(pipelines), volume_(volume) {}

void CoderPool::make_room_for(const Coding& coding, std::uint64_t raw_bytes) {
  const std::scoped_lock lock(mutex_);
  if (raw_bytes > max_raw_bytes_) {
    idle_.clear();
    max_raw_bytes_ = raw_bytes;
  }
  const BlockCoder sample(pipelines_.make_codec(coding.codec), max_raw_bytes_, coding.buffers,
                          coding.scratch_bytes);
  coder_bytes_ = std::max(coder_bytes_, sample.memory_bytes() + coding.maker_bytes);
  most_coders_ = static_cast<std::size_t>(
      std::clamp<std::uint64_t>(volume_.most_scratch_bytes / coder_bytes_, 1,
                                static_cast<std::uint64_t>(std::max(1, volume_.threads))));
  idle_.reserve(most_coders_);
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

KeptCoder CoderPool::take(const Coding& coding) {
  KeptCoder kept{coding, nullptr};
  std::uint64_t max_raw_bytes = 0;
  {
    std::unique_lock lock(mutex_);
    given_back_.wait(lock, [&] { return taken_ < most_coders_; });
    const auto found = std::ranges::find(idle_, coding, &KeptCoder::coding);
    ++taken_;
    if (found != idle_.end()) {
      kept.coder = std::move(found->coder);
      idle_.erase(found);
      return kept;
    }
    // A coder of another coding makes room: its memory counts.
    while (!idle_.empty() && idle_.size() + taken_ > most_coders_) idle_.erase(idle_.begin());
    max_raw_bytes = max_raw_bytes_;
  }
  try {
    kept.coder = std::make_unique<BlockCoder>(pipelines_.make_codec(coding.codec), max_raw_bytes,
                                              coding.buffers, coding.scratch_bytes);
    return kept;
  } catch (...) {
    give_back({});
    throw;
  }
}

void CoderPool::give_back(KeptCoder kept) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    --taken_;
    if (kept.coder && kept.coder->max_raw_bytes() == max_raw_bytes_ &&
        idle_.size() + taken_ < most_coders_)
      idle_.push_back(std::move(kept));
  }
  given_back_.notify_one();
}

PLAIT_END_NAMESPACE
