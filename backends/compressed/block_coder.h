// backends/compressed/block_coder.h: one block through its filter chain and codec, with the memory
// that this takes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
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
  /// Errors: as parse_pipeline, make_codec and make_filter_chain.
  BlockCoder(const std::string& pipeline, std::size_t component_bytes, std::uint64_t max_raw_bytes);

  std::uint64_t max_raw_bytes() const { return max_raw_bytes_; }
  /// The most memory that it takes, once it has coded.
  std::uint64_t memory_bytes() const;
  const std::string& pipeline() const { return pipeline_; }
  /// What blocks go through from now on. Errors: as the constructor's, and then nothing changes.
  void set_pipeline(const std::string& pipeline, std::size_t component_bytes);

  EncodedBlock encode(std::span<const std::byte> raw);
  /// Room for the stored bytes of a block, to be filled before decode().
  std::span<std::byte> stored_buffer(std::uint64_t stored_bytes);
  /// Errors: kCorruption.
  void decode(std::span<const std::byte> stored, std::span<std::byte> raw);

 private:
  using Buffer = std::vector<std::byte>;

  /// With the first block: most levels of a store that is opened are not read.
  void make_room();

  std::string pipeline_;
  std::size_t component_bytes_;
  std::unique_ptr<Codec> codec_;
  FilterChain filters_;
  std::uint64_t max_raw_bytes_;
  Buffer stored_;
  Buffer filtered_[2];  ///< where the stages of the chain take turns; empty if not needed
};

}  // namespace plait
