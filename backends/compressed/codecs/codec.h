// backends/compressed/codecs/codec.h: reversible compressors of one block.
//
// A codec gets bytes from the disk: decompress() must fill exactly the span it is given or throw,
// whatever it is fed, without touching a byte outside its spans.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

namespace plait {

/// May keep working memory of its own: one thread at a time.
class Codec {
 public:
  virtual ~Codec() = default;

  /// The most that compress() can need for `raw_bytes`.
  virtual std::size_t bound(std::size_t raw_bytes) const = 0;

  /// The most memory that it keeps once it has coded blocks of up to `raw_bytes`.
  virtual std::size_t memory_bytes(std::size_t raw_bytes) const = 0;

  /// The bytes used of `into`; nothing if the result does not fit, which is how a block that saves
  /// too little is found early. Errors: kOutOfMemory.
  virtual std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                              std::span<std::byte> into) = 0;

  /// Errors: kCorruption unless `stored` decodes to exactly raw.size() bytes.
  virtual void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) = 0;
};

/// Whether a stage of a pipeline, such as "zstd:3", has the name of a codec.
bool is_codec(std::string_view stage);

/// "none", "lz4", "zstd" (its default level) or "zstd:LEVEL" from ZSTD_minCLevel to maxCLevel.
/// Errors: kNotSupported naming the codecs there are; kInvalidArgument for a level out of range.
std::unique_ptr<Codec> make_codec(std::string_view specification);

std::unique_ptr<Codec> make_lz4_codec();
/// `level`: the text after "zstd:", if there is one.
std::unique_ptr<Codec> make_zstd_codec(std::optional<std::string_view> level);

}  // namespace plait
