// plait/extend/codec.h: the interface of a codec, the last stage of a pipeline.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A reversible compressor of one block. Only one thread uses an object at a time, so an object may
/// keep working memory.
class Codec {
 public:
  virtual ~Codec() = default;

  /// The largest size of the result of compress() for `raw_bytes`.
  virtual std::size_t bound(std::size_t raw_bytes) const = 0;

  /// The most memory, in bytes, that the object keeps after coding blocks of up to `raw_bytes`. The
  /// store subtracts this memory from its budget.
  virtual std::size_t memory_bytes(std::size_t raw_bytes) const = 0;

  /// Returns the number of bytes written to `into`, or nothing if the encoded block does not fit.
  /// The caller makes `into` so small that a block which saves too little does not fit. Errors:
  /// kOutOfMemory.
  virtual std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                              std::span<std::byte> into) = 0;

  /// Fills exactly `raw` or throws, for any bytes in `stored`: they come from a disk and may be
  /// damaged. Accesses no byte outside its spans. Errors: kCorruption unless `stored` decodes to
  /// raw.size() bytes.
  virtual void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) = 0;
};

PLAIT_END_NAMESPACE
