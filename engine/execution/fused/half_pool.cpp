#include "execution/fused/half_pool.h"

#include <sys/mman.h>

#include <cerrno>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The size of a slab, in whole huge pages: one page fault instead of hundreds. A slab has room for
/// at least eight halves, so at most an eighth of it is unused.
std::size_t slab_bytes(std::size_t half_bytes) {
  constexpr std::size_t kHugePage = 2 << 20, kLeastHalves = 8;
  return (kLeastHalves * half_bytes + kHugePage - 1) / kHugePage * kHugePage;
}

}  // namespace

std::uint64_t HalfPool::bytes(std::size_t half_bytes, std::uint64_t halves) {
  const std::size_t slab = slab_bytes(half_bytes), halves_a_slab = slab / half_bytes;
  return (halves + halves_a_slab - 1) / halves_a_slab * slab;
}

void HalfPool::Unmap::operator()(std::byte* memory) const { ::munmap(memory, bytes); }

auto HalfPool::map_slab() const -> Slab {
  const std::size_t bytes = slab_bytes(half_bytes_);
  void* const memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw system_error("map", "memory for waiting halves of slots", errno);
  ::madvise(memory, bytes, MADV_HUGEPAGE);
  return {static_cast<std::byte*>(memory), Unmap{bytes}};
}

void HalfPool::take(std::span<std::byte*> halves) {
  std::unique_lock lock(mutex_);
  for (std::byte*& half : halves) {
    while (vacant_.empty()) {
      // Not with the lock: the system makes a thread wait for the page faults of all others.
      lock.unlock();
      Slab mapped = map_slab();
      lock.lock();
      const Slab& slab = slabs_.emplace_back(std::move(mapped));
      for (std::size_t at = slab.get_deleter().bytes / half_bytes_; at-- > 0;)
        vacant_.push_back(slab.get() + at * half_bytes_);
    }
    half = vacant_.back();
    vacant_.pop_back();
  }
}

void HalfPool::give_back(std::span<std::byte* const> halves) {
  const std::scoped_lock lock(mutex_);
  vacant_.insert(vacant_.end(), halves.begin(), halves.end());
}

PLAIT_END_NAMESPACE
