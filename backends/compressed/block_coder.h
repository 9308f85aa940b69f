// backends/compressed/block_coder.h: encodes and decodes one block with a pipeline, and owns the
// buffers for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/backends/pipeline.h"
#include "plait/block_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The largest stored size of an encoded block of `raw_bytes`. If encoding saves less than 1/8, the
/// block is stored raw.
constexpr std::uint64_t max_encoded_bytes(std::uint64_t raw_bytes) {
  return raw_bytes - (raw_bytes + 7) / 8;
}

struct EncodedBlock {
  BlockEncoding encoding;  ///< kRaw or kEncoded
  /// kRaw: the caller's bytes. kEncoded: the coder's, valid until its next call.
  std::span<const std::byte> bytes;
};

/// One thread at a time.
class BlockCoder {
 public:
  BlockCoder(Pipeline pipeline, std::uint64_t max_raw_bytes);

  std::uint64_t max_raw_bytes() const { return max_raw_bytes_; }
  /// The most memory that the coder takes, after its first block.
  std::uint64_t memory_bytes() const;

  EncodedBlock encode(std::span<const std::byte> raw);
  /// The buffer for the stored bytes of a block. The caller fills it before decode().
  std::span<std::byte> stored_buffer(std::uint64_t stored_bytes);
  /// Errors: kCorruption.
  void decode(std::span<const std::byte> stored, std::span<std::byte> raw);

 private:
  using Buffer = std::vector<std::byte>;

  /// Allocates the buffers, with the first block: most levels of an open store are never read.
  void make_room();

  Pipeline pipeline_;
  std::uint64_t max_raw_bytes_;
  Buffer stored_;
  Buffer filtered_[2];  ///< the filters write to them in turn; empty if not needed
};

PLAIT_END_NAMESPACE
