// backends/compressed/block_coder.h: encodes and decodes blocks, and owns the buffers for it.
//
// An encoded block whose filter needs other blocks begins with the seal of these blocks, 8 bytes;
// then comes the note of the first filter, one byte, if it keeps one (docs/format.md, "Level
// files").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "plait/extend/block_table.h"
#include "plait/extend/codec.h"
#include "plait/extend/filter.h"

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

/// The filters of a level, and what they need. Immutable.
using Filters = std::vector<std::unique_ptr<Filter>>;
std::size_t scratch_bytes(const Filters& filters) noexcept;
bool need_other_blocks(const Filters& filters) noexcept;
bool keep_note(const Filters& filters) noexcept;

/// One block on its way through filters.
struct CodedBlock {
  const Filters& filters;
  FilterBlock block = {};
  /// The seal of the blocks that the first filter needs; nothing if the filters need none.
  std::optional<std::uint64_t> context_seal = {};
};

/// A codec with its buffers, for blocks of levels with any filters. One thread at a time.
class BlockCoder {
 public:
  /// `buffers`: 0, 1 or 2 for levels with no filter, one filter, or more.
  BlockCoder(std::unique_ptr<Codec> codec, std::uint64_t max_raw_bytes, std::size_t buffers,
             std::size_t scratch_bytes);

  std::uint64_t max_raw_bytes() const { return max_raw_bytes_; }
  /// The most memory that the coder takes, after its first block.
  std::uint64_t memory_bytes() const;

  EncodedBlock encode(const CodedBlock& block, std::span<const std::byte> raw);
  /// The buffer for the stored bytes of a block. The caller fills it before decode().
  std::span<std::byte> stored_buffer(std::uint64_t stored_bytes);
  /// Errors: kCorruption, also if the block was encoded with other context.
  void decode(const CodedBlock& block, std::span<const std::byte> stored, std::span<std::byte> raw);

 private:
  using Buffer = std::vector<std::byte>;

  /// Allocates the buffers, with the first block: most levels of an open store are never read.
  void make_room();
  FilterBlock with_scratch(const FilterBlock& block, std::byte* note);

  std::unique_ptr<Codec> codec_;
  std::uint64_t max_raw_bytes_;
  std::size_t buffers_, scratch_bytes_;
  Buffer stored_, scratch_;
  Buffer filtered_[2];  ///< the filters write to them in turn; empty if not needed
};

PLAIT_END_NAMESPACE
