// backends/compressed/block_coder.h: one block through its filter chain and codec, with the memory
// that this takes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "compressed/codecs/codec.h"
#include "compressed/filters/filter.h"
#include "plait/block_table.h"

namespace plait {

/// The largest stored size of an encoded block of `raw_bytes`: one that saves less than 1/8 is
/// stored raw.
constexpr std::uint64_t max_encoded_bytes(std::uint64_t raw_bytes) {
  return raw_bytes - (raw_bytes + 7) / 8;
}

struct EncodedBlock {
  BlockEncoding encoding;            ///< kRaw or kEncoded
  std::span<const std::byte> bytes;  ///< the caller's raw bytes, or the coder's until its next use
};

/// One thread at a time.
class BlockCoder {
 public:
  BlockCoder(const std::string& codec, const std::string& filter, std::size_t component_bytes,
             std::uint64_t max_raw_bytes);

  EncodedBlock encode(std::span<const std::byte> raw);
  /// Room for the stored bytes of a block, to be filled before decode().
  std::span<std::byte> stored_buffer(std::uint64_t stored_bytes);
  /// Errors: kCorruption.
  void decode(std::span<const std::byte> stored, std::span<std::byte> raw);

 private:
  using Buffer = std::vector<std::byte>;

  /// With the first block: most levels of a store that is opened are not read.
  void make_room();

  std::unique_ptr<Codec> codec_;
  FilterChain filters_;
  std::uint64_t max_raw_bytes_;
  Buffer stored_;
  Buffer filtered_[2];  ///< where the stages of the chain take turns; empty if not needed
};

/// Coders that are kept for the next caller, because their memory is faulted in and their contexts
/// are set up: there will be as many as there are threads. Safe from any thread.
class CoderPool {
 public:
  CoderPool(std::string codec, std::string filter, std::size_t component_bytes,
            std::uint64_t max_raw_bytes);

  class Lease {
   public:
    explicit Lease(CoderPool& pool) : pool_(pool), coder_(pool.take()) {}
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
  std::unique_ptr<BlockCoder> take();
  void give_back(std::unique_ptr<BlockCoder> coder) noexcept;

  std::string codec_, filter_;
  std::size_t component_bytes_;
  std::uint64_t max_raw_bytes_;
  std::mutex mutex_;
  std::size_t made_count_ = 0;
  std::vector<std::unique_ptr<BlockCoder>> idle_;  ///< capacity for all that were made
};

}  // namespace plait
