// Memory for halves that wait for the other half of their edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// take() returns the memory that was given back last, because it is still in the cache. Only one
/// thread at a time may use a pool.
class HalfPool {
 public:
  explicit HalfPool(std::size_t half_bytes) : half_bytes_(half_bytes) {}
  /// The memory that a pool needs for `halves` halves at once.
  static std::uint64_t bytes(std::size_t half_bytes, std::uint64_t halves);
  /// Memory for one half. It is aligned to cache lines if half_bytes is a multiple of a line.
  std::byte* take();
  void give_back(std::byte* half) { vacant_.push_back(half); }

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* memory) const;
  };
  std::size_t half_bytes_;
  std::vector<std::byte*> vacant_;
  std::vector<std::unique_ptr<std::byte, Unmap>> slabs_;
};

PLAIT_END_NAMESPACE
