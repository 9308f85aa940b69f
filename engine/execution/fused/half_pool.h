// Memory for halves that wait for the other half of their edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// take() returns the memory that was given back last, because it is still in the cache. Threads:
/// shared; a thread takes and gives back many halves in one call, because each call locks.
class HalfPool {
 public:
  explicit HalfPool(std::size_t half_bytes) : half_bytes_(half_bytes) {}
  /// The memory that a pool needs for `halves` halves at once.
  static std::uint64_t bytes(std::size_t half_bytes, std::uint64_t halves);
  /// Memory for each of these halves. It is aligned to cache lines if half_bytes is a multiple of a
  /// line. Errors: kIo; std::bad_alloc.
  void take(std::span<std::byte*> halves);
  void give_back(std::span<std::byte* const> halves);

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* memory) const;
  };
  using Slab = std::unique_ptr<std::byte, Unmap>;
  Slab map_slab() const;

  std::size_t half_bytes_;
  std::mutex mutex_;  ///< for the following
  std::vector<std::byte*> vacant_;
  std::vector<Slab> slabs_;
};

PLAIT_END_NAMESPACE
