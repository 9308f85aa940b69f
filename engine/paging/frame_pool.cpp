#include "paging/frame_pool.h"

#include <algorithm>
#include <new>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

FramePool::~FramePool() {
  for (auto& [bytes, list] : idle_)
    while (list) ::operator delete(pop(list), std::align_val_t(kAlignment));
}

std::byte* FramePool::pop(Idle*& list) noexcept {
  return reinterpret_cast<std::byte*>(std::exchange(list, list->next));
}

bool FramePool::make_room(std::uint64_t bytes) noexcept {
  if (used_bytes_ + bytes > budget_bytes()) return false;
  for (auto largest = idle_.rbegin(); largest != idle_.rend(); ++largest)
    while (largest->second && used_bytes_ + idle_bytes_ + bytes > budget_bytes()) {
      ::operator delete(pop(largest->second), std::align_val_t(kAlignment));
      idle_bytes_ -= largest->first;
    }
  return true;
}

std::byte* FramePool::take(std::uint64_t bytes) {
  Idle*& list = idle_.find(bytes)->second;
  if (used_bytes_ + bytes > budget_bytes()) return nullptr;
  std::byte* memory = nullptr;
  if (list) {
    memory = pop(list);
    idle_bytes_ -= bytes;
  } else {
    make_room(bytes);
    memory = static_cast<std::byte*>(::operator new(bytes, std::align_val_t(kAlignment)));
  }
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return memory;
}

void FramePool::give_back(std::byte* memory, std::uint64_t bytes) noexcept {
  used_bytes_ -= bytes;
  idle_bytes_ += bytes;
  Idle*& list = idle_.find(bytes)->second;
  list = new (memory) Idle{list};
}

bool FramePool::reserve(std::uint64_t bytes) noexcept {
  if (!make_room(bytes)) return false;
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return true;
}

void FramePool::set_aside(std::uint64_t bytes) noexcept {
  aside_bytes_ = std::min(bytes, budget_bytes_);
  if (used_bytes_ <= budget_bytes()) make_room(0);
}

PLAIT_END_NAMESPACE
