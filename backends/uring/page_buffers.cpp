#include "uring/page_buffers.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

PageBuffers::PageBuffers(std::uint64_t most_bytes) : most_bytes_(most_bytes) {
  idle_.reserve(kMostBuffers);
}

PageBuffers::Room PageBuffers::with(Room room, std::uint64_t bytes, bool often) const noexcept {
  room.often = room.often || often;
  room.buffer_bytes = std::max(room.buffer_bytes, bytes);
  if (room.often && room.buffer_bytes > 0)
    room.count = std::clamp<std::uint64_t>(most_bytes_ / room.buffer_bytes, 1, kMostBuffers);
  return room;
}

std::uint64_t PageBuffers::memory_of(const Room& room) const noexcept {
  return room.often ? std::min(room.count * room.buffer_bytes, most_bytes_) : 0;
}

PageBuffers::Room PageBuffers::room() const noexcept {
  const std::scoped_lock lock(mutex_);
  return room_;
}

void PageBuffers::make_room_for(std::uint64_t bytes, bool often) {
  const std::scoped_lock lock(mutex_);
  if (bytes > room_.buffer_bytes) idle_.clear();
  room_ = with(room_, bytes, often);
}

std::uint64_t PageBuffers::memory_bytes() const noexcept {
  const std::scoped_lock lock(mutex_);
  return memory_of(room_);
}

std::uint64_t PageBuffers::count() const noexcept {
  const std::scoped_lock lock(mutex_);
  return room_.count;
}

PageBuffers::Buffer PageBuffers::take() {
  std::unique_lock lock(mutex_);
  given_back_.wait(lock, [&] { return taken_ < room_.count; });
  ++taken_;
  if (!idle_.empty()) {
    Buffer buffer = std::move(idle_.back());
    idle_.pop_back();
    return buffer;
  }
  Buffer buffer;
  buffer.bytes = room_.buffer_bytes;
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
  if (buffer.bytes == room_.buffer_bytes && idle_.size() + taken_ <= room_.count)
    idle_.push_back(std::move(buffer));
  --taken_;
  given_back_.notify_one();
}

PLAIT_END_NAMESPACE
