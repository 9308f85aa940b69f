// backends/compressed/coder_pool.h: the coders of all levels of one store.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "compressed/block_coder.h"
#include "plait/backend.h"

namespace plait {

/// Keeps coders for the next caller: their memory is faulted in and their contexts are set up. The
/// pool has one coder per thread, or fewer if the memory is short. A caller waits if all coders are
/// in use. Safe from any thread.
class CoderPool {
 public:
  /// Errors: as make_codec and make_filter_chain.
  explicit CoderPool(const VolumeSpec& volume);

  /// Prepares for blocks of up to `raw_bytes`. Coders for smaller blocks are deleted when their
  /// users return them.
  void make_room_for(std::uint64_t raw_bytes);
  /// The most memory that all coders together take, but not more than `most_scratch_bytes`. The
  /// pool always has one coder; if that coder alone takes more, the rest is not counted here.
  std::uint64_t memory_bytes() const noexcept;
  std::size_t most_coders() const noexcept;
  /// Frees the memory of the coders that are not in use.
  void shrink() noexcept;

  class Lease {
   public:
    Lease(CoderPool& pool, std::size_t component_bytes)
        : pool_(pool), coder_(pool.take(component_bytes)) {}
    ~Lease() { pool_.give_back(std::move(coder_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    BlockCoder& operator*() { return *coder_; }
    BlockCoder* operator->() { return coder_.get(); }

   private:
    CoderPool& pool_;
    std::unique_ptr<BlockCoder> coder_;
  };

 private:
  std::unique_ptr<BlockCoder> take(std::size_t component_bytes);
  void give_back(std::unique_ptr<BlockCoder> coder) noexcept;

  VolumeSpec volume_;
  mutable std::mutex mutex_;
  std::uint64_t max_raw_bytes_ = 0, coder_bytes_ = 0;
  std::size_t most_coders_ = 1;
  std::condition_variable given_back_;
  std::size_t taken_ = 0;
  std::vector<std::unique_ptr<BlockCoder>> idle_;  ///< has room for most_coders_
};

}  // namespace plait
