// plait/extend/filter.h: the interface of a filter, a stage of a pipeline before its codec.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"

PLAIT_BEGIN_NAMESPACE

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

PLAIT_END_NAMESPACE
