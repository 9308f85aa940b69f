#include "uring/page_buffers.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

PageBuffers::PageBuffers(std::uint64_t most_bytes) : most_bytes_(most_bytes) {
  idle_.reserve(kMostBuffers);
}

void PageBuffers::make_room_for(std::uint64_t bytes, bool often) {
  const std::scoped_lock lock(mutex_);
  often_ = often_ || often;
  if (bytes > buffer_bytes_) {
    idle_.clear();
    buffer_bytes_ = bytes;
  }
  if (often_ && buffer_bytes_ > 0)
    count_ = std::clamp<std::uint64_t>(most_bytes_ / buffer_bytes_, 1, kMostBuffers);
}

std::uint64_t PageBuffers::memory_bytes() const noexcept {
  const std::scoped_lock lock(mutex_);
  return often_ ? std::min(count_ * buffer_bytes_, most_bytes_) : 0;
}

std::uint64_t PageBuffers::count() const noexcept {
  const std::scoped_lock lock(mutex_);
  return count_;
}

PageBuffers::Buffer PageBuffers::take() {
  std::unique_lock lock(mutex_);
  given_back_.wait(lock, [&] { return taken_ < count_; });
  ++taken_;
  if (!idle_.empty()) {
    Buffer buffer = std::move(idle_.back());
    idle_.pop_back();
    return buffer;
  }
  Buffer buffer;
  buffer.bytes = buffer_bytes_;
  lock.unlock();
  try {
    buffer.memory.reset(
        static_cast<std::byte*>(::operator new(buffer.bytes, std::align_val_t(kPageBytes))));
  } catch (...) {
    lock.lock();
    --taken_;
    given_back_.notify_one();
    throw;
  }
  return buffer;
}

void PageBuffers::give_back(Buffer buffer) noexcept {
  const std::scoped_lock lock(mutex_);
  if (buffer.bytes == buffer_bytes_ && idle_.size() + taken_ <= count_)
    idle_.push_back(std::move(buffer));
  --taken_;
  given_back_.notify_one();
}

PLAIT_END_NAMESPACE
