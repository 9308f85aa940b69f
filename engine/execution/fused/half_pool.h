// Memory for halves that wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace plait {

/// What was given back last is taken first: it is still in cache. One thread at a time.
class HalfPool {
 public:
  explicit HalfPool(std::size_t half_bytes) : half_bytes_(half_bytes) {}
  /// Memory that it takes for so many at once.
  static std::uint64_t bytes(std::size_t half_bytes, std::uint64_t halves);
  /// Aligned to lines of the cache where half_bytes is.
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

}  // namespace plait
