#include "paging/frame_pool.h"

#include <algorithm>
#include <new>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

FramePool::~FramePool() { release(); }

void FramePool::release() noexcept {
  for (auto& [bytes, list] : idle_)
    while (list) ::operator delete(pop(list), std::align_val_t(kAlignment));
  idle_bytes_ = 0;
  if (shared_) shared_->give_back(std::exchange(lent_bytes_, 0));
}

std::byte* FramePool::pop(Idle*& list) noexcept {
  return reinterpret_cast<std::byte*>(std::exchange(list, list->next));
}

bool FramePool::may_use(std::uint64_t bytes) noexcept {
  if (!return_surplus() && used_bytes_ + bytes > budget_bytes()) return false;
  if (used_bytes_ + bytes <= capacity_bytes()) return true;
  if (!shared_) return false;
  const std::uint64_t more = used_bytes_ + bytes - capacity_bytes();
  if (!shared_->lend(lent_bytes_, more)) return false;
  lent_bytes_ += more;
  return true;
}

bool FramePool::return_surplus() noexcept {
  if (lent_bytes_ == 0) return true;
  const std::uint64_t portion = shared_->portion_bytes();
  if (lent_bytes_ <= portion) return true;
  const std::uint64_t unused = capacity_bytes() - std::min(capacity_bytes(), used_bytes_);
  const std::uint64_t returned = std::min(lent_bytes_ - portion, unused);
  lent_bytes_ -= returned;
  make_room(0);
  shared_->give_back(returned);
  return lent_bytes_ <= portion;
}

void FramePool::make_room(std::uint64_t bytes) noexcept {
  for (auto largest = idle_.rbegin(); largest != idle_.rend(); ++largest)
    while (largest->second && used_bytes_ + idle_bytes_ + bytes > capacity_bytes()) {
      ::operator delete(pop(largest->second), std::align_val_t(kAlignment));
      idle_bytes_ -= largest->first;
    }
}

std::byte* FramePool::take(std::uint64_t bytes) {
  Idle*& list = idle_.find(bytes)->second;
  if (!may_use(bytes)) return nullptr;
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
  if (!may_use(bytes)) return false;
  make_room(bytes);
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return true;
}

void FramePool::set_aside(std::uint64_t bytes) noexcept {
  aside_bytes_ = std::min(bytes, budget_bytes_);
  if (used_bytes_ <= capacity_bytes()) make_room(0);
}

PLAIT_END_NAMESPACE
