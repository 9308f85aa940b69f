#include "paging/frame_pool.h"

#include <algorithm>
#include <new>

namespace plait {

FramePool::~FramePool() {
  for (auto& [bytes, frames] : idle_)
    for (std::byte* memory : frames) ::operator delete(memory, std::align_val_t(kAlignment));
}

bool FramePool::make_room(std::uint64_t bytes) {
  if (used_bytes_ + bytes > budget_bytes_) return false;
  while (used_bytes_ + idle_bytes_ + bytes > budget_bytes_) {
    const auto largest = std::prev(idle_.end());
    ::operator delete(largest->second.back(), std::align_val_t(kAlignment));
    idle_bytes_ -= largest->first;
    largest->second.pop_back();
    if (largest->second.empty()) idle_.erase(largest);
  }
  return true;
}

std::byte* FramePool::take(std::uint64_t bytes) {
  std::byte* memory = nullptr;
  if (const auto found = idle_.find(bytes); found != idle_.end()) {
    memory = found->second.back();
    found->second.pop_back();
    idle_bytes_ -= bytes;
    if (found->second.empty()) idle_.erase(found);
  } else {
    if (!make_room(bytes)) return nullptr;
    memory = static_cast<std::byte*>(::operator new(bytes, std::align_val_t(kAlignment)));
  }
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return memory;
}

void FramePool::give_back(std::byte* memory, std::uint64_t bytes) {
  used_bytes_ -= bytes;
  idle_bytes_ += bytes;
  idle_[bytes].push_back(memory);
}

bool FramePool::reserve(std::uint64_t bytes) {
  if (!make_room(bytes)) return false;
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return true;
}

}  // namespace plait
