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
// contain neither a comma nor a plus sign; semicolons separate pipelines (plait/level_pipelines.h).
// The first filter may be the stage `predicted`, which stores blocks that a scheme makes again in
// no bytes (plait/block_maker.h). The codec "none" copies; the filter "none" stands for no filter.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/attribute.h"
#include "plait/backend.h"
#include "plait/block_maker.h"
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

/// The level whose blocks a filter transforms. A filter may keep what this struct and
/// `surroundings` refer to: geometries, base records and the mesh outlive the filter. The two
/// structs themselves end with the call.
struct FilterLevel {
  AttributeSchema schema = {};  ///< the type of the records
  /// Where the slots of a block are. Null if the filter is only made to find out whether the schema
  /// suits it.
  const LevelGeometry* geometry = nullptr;
  std::uint32_t attribute = 0;  ///< the attribute's number, as in BlockTable
  int level = 0;
  /// The mesh, and the levels that may be context. Null where they are not known; then encode() and
  /// decode() of a filter that needs other blocks throw kNotSupported.
  const LevelSurroundings* surroundings = nullptr;
};

/// One block on its way through a filter.
struct FilterBlock {
  std::uint64_t block = 0;
  /// The raw bytes of the blocks that Filter::context() named, in that order.
  std::span<const std::span<const std::byte>> context = {};
  /// Working memory of Filter::scratch_bytes() bytes, aligned as by operator new.
  std::span<std::byte> scratch = {};
  /// Of the first filter, if it keeps_note(): the byte that encode() sets and that decode() gets
  /// back. Null if the caller stores no such byte.
  std::byte* note = nullptr;
};

/// A reversible transform of the blocks of one level. It keeps the size and makes a block compress
/// better. A filter does not change, so any number of threads may use it.
class Filter {
 public:
  virtual ~Filter() = default;
  /// Whether context() names blocks, for any block. Only the first filter of a pipeline may need
  /// other blocks.
  virtual bool needs_other_blocks() const noexcept { return false; }
  /// As Backend::context().
  virtual std::size_t context(std::uint64_t block,
                              std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
    static_cast<void>(block), static_cast<void>(blocks);
    return 0;
  }
  /// Whether encode() decides something about each block that decode() must know:
  /// FilterBlock::note. Only the first filter of a pipeline may.
  virtual bool keeps_note() const noexcept { return false; }
  /// The number of the attribute whose base records (AttributeLevels::base) the filter reads; kNoId
  /// if it reads none.
  virtual std::uint32_t base_attribute() const noexcept { return kNoId; }
  /// The working memory that one call of encode() or decode() needs.
  virtual std::size_t scratch_bytes() const noexcept { return 0; }
  /// The two spans have the size of the block and do not overlap.
  virtual void encode(const FilterBlock& block, std::span<const std::byte> raw,
                      std::span<std::byte> filtered) const = 0;
  /// The inverse of encode(). Accepts any bytes. Errors: kCorruption for a note that encode() never
  /// sets.
  virtual void decode(const FilterBlock& block, std::span<const std::byte> filtered,
                      std::span<std::byte> raw) const = 0;
};

/// One pipeline for the blocks of one level. Encoding applies filters.front() first, decoding
/// applies it last.
struct Pipeline {
  std::vector<std::unique_ptr<Filter>> filters;
  std::unique_ptr<Codec> codec;
  /// Of the stage `predicted`; nullptr without it, and if it makes no block of this level.
  std::shared_ptr<const BlockMaker> maker = {};
  std::string why_no_maker = {};  ///< why predicted blocks cannot be made, for messages
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
    /// As in CodecEntry. Returns nullptr if the filter would change nothing for records of this
    /// type. Throws kNotSupported for records that the filter cannot transform.
    std::function<std::unique_ptr<Filter>(std::string_view options, const FilterLevel& level)>
        make = {};
  };

  /// Errors: kInvalidArgument for a name that is taken, is empty, or holds a character other than
  /// [A-Za-z0-9_-], and for an empty `make`.
  void add(CodecEntry entry);
  void add(FilterEntry entry);

  /// What the stage `predicted` makes. nullptr: nothing.
  void set_block_makers(std::shared_ptr<const BlockMakers> makers) { makers_ = std::move(makers); }
  const BlockMakers* block_makers() const { return makers_.get(); }

  std::vector<std::string> codec_names() const;
  std::vector<std::string> filter_names() const;

  /// Errors: kNotSupported for a name that is not registered (the message lists the known names),
  /// for records that a filter cannot transform, and if a filter after the first one needs other
  /// blocks or keeps a note; kInvalidArgument for text that is no pipeline and for options that are
  /// refused.
  Pipeline make(std::string_view pipeline, const FilterLevel& level) const;
  /// Only the codec of the pipeline. Errors: as make().
  std::unique_ptr<Codec> make_codec(std::string_view pipeline) const;

 private:
  std::map<std::string, CodecEntry, std::less<>> codecs_;
  std::map<std::string, FilterEntry, std::less<>> filters_;
  std::shared_ptr<const BlockMakers> makers_;
};

/// The codecs and filters of docs/format.md. Built once; safe from any thread.
const PipelineRegistry& default_pipelines();

PLAIT_END_NAMESPACE
