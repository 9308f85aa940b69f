// plait/backends/pipeline.h: how the compressed backend encodes a block: filters, one after
// another, then a codec. Both are registered by name, as backends are. A program adds its own to a
// copy of default_pipelines(), and opens stores with default_backends(copy).
//
// A pipeline is written as a string:
//
//   PIPELINE = [FILTER { "+" FILTER } ","] CODEC         FILTER, CODEC = NAME [":" OPTIONS]
//
//   shuffle,zstd:3      lz4      shuffle,none      x-delta:stride=3+shuffle,zstd
//
// The first comma ends the filters. So a codec's options may contain commas, and a filter's options
// contain neither a comma nor a plus sign. The codec "none" copies; the filter "none" stands for no
// filter.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/namespace.h"

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

/// A reversible transform of one block. It keeps the size and makes the block compress better. A
/// filter has no state, so any number of threads may use it.
class Filter {
 public:
  virtual ~Filter() = default;
  /// The two spans have one size and do not overlap.
  virtual void encode(std::span<const std::byte> raw, std::span<std::byte> filtered) const = 0;
  /// The inverse of encode(). Accepts any bytes.
  virtual void decode(std::span<const std::byte> filtered, std::span<std::byte> raw) const = 0;
};

/// One pipeline for blocks of one attribute. Encoding applies filters.front() first, decoding
/// applies it last.
struct Pipeline {
  std::vector<std::unique_ptr<Filter>> filters;
  std::unique_ptr<Codec> codec;
};

/// Finds codecs and filters by name. Only one thread may call add(); all other calls are safe from
/// any number of threads.
class PipelineRegistry {
 public:
  /// A codec: its name, and the function that makes one.
  struct CodecEntry {
    std::string name = {};
    std::string summary = {};  ///< one line for --help, which also explains the options
    /// `options` is the text after the colon, empty without one. Throws kInvalidArgument for
    /// options that the codec does not take.
    std::function<std::unique_ptr<Codec>(std::string_view options)> make = {};
  };
  /// A filter: its name, and the function that makes one.
  struct FilterEntry {
    std::string name = {};
    std::string summary = {};
    /// As in CodecEntry. `component_bytes` is the size of one number of the attribute: 1, 2, 4 or
    /// 8. Returns nullptr if the filter would change nothing for this size.
    std::function<std::unique_ptr<Filter>(std::string_view options, std::size_t component_bytes)>
        make = {};
  };

  /// Errors: kInvalidArgument for a name that is taken, is empty, or holds a character other than
  /// [A-Za-z0-9_-], and for an empty `make`.
  void add(CodecEntry entry);
  void add(FilterEntry entry);

  std::vector<std::string> codec_names() const;
  std::vector<std::string> filter_names() const;

  /// Errors: kNotSupported for a name that is not registered (the message lists the known names);
  /// kInvalidArgument for text that is no pipeline, for options that are refused, and for
  /// `component_bytes` other than 1, 2, 4 and 8.
  Pipeline make(std::string_view pipeline, std::size_t component_bytes) const;

 private:
  std::map<std::string, CodecEntry, std::less<>> codecs_;
  std::map<std::string, FilterEntry, std::less<>> filters_;
};

/// Codecs none, lz4 and zstd, filter shuffle. Built once; safe from any thread.
const PipelineRegistry& default_pipelines();

PLAIT_END_NAMESPACE
