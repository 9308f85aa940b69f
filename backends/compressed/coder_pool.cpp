#include "compressed/coder_pool.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

CoderPool::CoderPool(const PipelineRegistry& pipelines, const VolumeSpec& volume)
    : pipelines_(pipelines), volume_(volume) {}

CoderPool::Room CoderPool::with(Room room, const Coding& coding, std::uint64_t raw_bytes) const {
  room.max_raw_bytes = std::max(room.max_raw_bytes, raw_bytes);
  const BlockCoder sample(pipelines_.make_codec(coding.codec), room.max_raw_bytes, coding.buffers,
                          coding.scratch_bytes);
  room.coder_bytes = std::max(room.coder_bytes, sample.memory_bytes() + coding.maker_bytes);
  room.most_coders = static_cast<std::size_t>(
      std::clamp<std::uint64_t>(volume_.most_scratch_bytes / room.coder_bytes, 1,
                                static_cast<std::uint64_t>(std::max(1, volume_.threads))));
  return room;
}

std::uint64_t CoderPool::memory_of(const Room& room) const noexcept {
  return std::min(room.most_coders * room.coder_bytes, volume_.most_scratch_bytes);
}

CoderPool::Room CoderPool::room() const {
  const std::scoped_lock lock(mutex_);
  return room_;
}

void CoderPool::make_room_for(const Coding& coding, std::uint64_t raw_bytes) {
  const std::scoped_lock lock(mutex_);
  const Room grown = with(room_, coding, raw_bytes);
  if (grown.max_raw_bytes > room_.max_raw_bytes) idle_.clear();
  room_ = grown;
  idle_.reserve(room_.most_coders);
}

std::uint64_t CoderPool::memory_bytes() const noexcept {
  const std::scoped_lock lock(mutex_);
  return memory_of(room_);
}

std::size_t CoderPool::most_coders() const noexcept {
  const std::scoped_lock lock(mutex_);
  return room_.most_coders;
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
    given_back_.wait(lock, [&] { return taken_ < room_.most_coders; });
    const auto found = std::ranges::find(idle_, coding, &KeptCoder::coding);
    ++taken_;
    if (found != idle_.end()) {
      kept.coder = std::move(found->coder);
      idle_.erase(found);
      return kept;
    }
    // A coder of another coding makes room: its memory counts.
    while (!idle_.empty() && idle_.size() + taken_ > room_.most_coders) idle_.erase(idle_.begin());
    max_raw_bytes = room_.max_raw_bytes;
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
    if (kept.coder && kept.coder->max_raw_bytes() == room_.max_raw_bytes &&
        idle_.size() + taken_ < room_.most_coders)
      idle_.push_back(std::move(kept));
  }
  given_back_.notify_one();
}

PLAIT_END_NAMESPACE
