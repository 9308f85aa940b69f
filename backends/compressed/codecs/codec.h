// backends/compressed/codecs/codec.h: reversible compressors of one block.
//
// A codec gets bytes from the disk, and they may be damaged. Whatever they are, decompress() must
// fill exactly the output span or throw, and must not access a byte outside its spans.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace plait {

/// A codec may keep working memory, so only one thread may use it at a time.
class Codec {
 public:
  virtual ~Codec() = default;

  /// The largest size of the result of compress() for `raw_bytes`.
  virtual std::size_t bound(std::size_t raw_bytes) const = 0;

  /// The most memory that the codec keeps after coding blocks of up to `raw_bytes`.
  virtual std::size_t memory_bytes(std::size_t raw_bytes) const = 0;

  /// Returns the number of bytes written to `into`, or nothing if the result does not fit. The
  /// caller makes `into` so small that a block which saves too little does not fit.
  /// Errors: kOutOfMemory.
  virtual std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                              std::span<std::byte> into) = 0;

  /// Errors: kCorruption unless `stored` decodes to exactly raw.size() bytes.
  virtual void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) = 0;
};

/// "none", "lz4", "zstd" (its default level) or "zstd:LEVEL" from ZSTD_minCLevel to maxCLevel.
/// Errors: kNotSupported (the message lists the known codecs); kInvalidArgument for a level out of
/// range.
std::unique_ptr<Codec> make_codec(std::string_view specification);

std::unique_ptr<Codec> make_lz4_codec();
/// `level`: the text after "zstd:", if there is one.
std::unique_ptr<Codec> make_zstd_codec(std::optional<std::string_view> level);

}  // namespace plait
