// backends/compressed/coder_pool.h: the coders of all levels of one store.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "compressed/block_coder.h"
#include "plait/backend.h"

namespace plait {

/// Coders that are kept for the next caller, because their memory is faulted in and their contexts
/// are set up. There are as many as there are threads, or as the memory allows: whoever finds none
/// waits for one. Safe from any thread.
class CoderPool {
 public:
  explicit CoderPool(const VolumeSpec& volume);

  /// Blocks of so many bytes will go through this pipeline. Coders for smaller ones go as they are
  /// given back. Errors: as BlockCoder.
  void make_room_for(const std::string& pipeline, std::uint64_t raw_bytes);
  /// The most memory that all coders together take. One there is in any case: what it takes beyond
  /// `most_scratch_bytes` is not counted here.
  std::uint64_t memory_bytes() const noexcept;
  std::size_t most_coders() const noexcept;
  /// Gives back the memory of coders that nobody uses.
  void shrink() noexcept;

  class Lease {
   public:
    /// REQUIRES: make_room_for() has had the pipeline.
    Lease(CoderPool& pool, const std::string& pipeline, std::size_t component_bytes)
        : pool_(pool), coder_(pool.take(pipeline, component_bytes)) {}
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
  std::unique_ptr<BlockCoder> take(const std::string& pipeline, std::size_t component_bytes);
  std::uint64_t largest_coder_bytes(std::uint64_t raw_bytes) const;
  void give_back(std::unique_ptr<BlockCoder> coder) noexcept;

  VolumeSpec volume_;
  mutable std::mutex mutex_;
  std::set<std::string> pipelines_;
  std::uint64_t max_raw_bytes_ = 1, coder_bytes_ = 1;  ///< of the pipeline that takes most
  std::size_t most_coders_ = 1;
  std::condition_variable given_back_;
  std::size_t taken_ = 0;
  std::vector<std::unique_ptr<BlockCoder>> idle_;  ///< has room for most_coders_
};

}  // namespace plait
