// Makes blocks and base records of a damaged store again: from its base mesh, and from its other
// attributes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/extend/block_maker.h"
#include "plait/extend/check_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For one thread. The caller must compare the results with checksums, because an attribute of this
/// name and type may have other records.
class MadeAgain {
 public:
  enum class From : std::uint8_t { kBaseMesh, kAttributes };
  /// Valid until the next call. Nothing if no maker makes these records.
  using Records = std::optional<std::span<const std::byte>>;

  /// `check` outlives this object. `makers` may be null.
  MadeAgain(const StoreCheck& check, std::shared_ptr<const BlockMakers> makers)
      : check_(check), makers_(std::move(makers)) {}

  /// From now on, blocks are made from the other attributes of the store too. `store` is the one
  /// that was checked, and outlives this object.
  void read_from(Store& store) { store_ = &store; }

  /// The records of a block of a level. Nothing also if a block that it is made from is damaged.
  /// Errors: those of reading blocks, but kCorruption.
  Records block(From from, const std::string& attribute, const LevelGeometry& geometry,
                std::uint64_t block);
  /// The records of the base vertices, from the base mesh.
  Records base_records(const std::string& attribute);
  /// Why the last call for the base mesh returned nothing.
  const std::string& refusal() const { return refusal_; }

 private:
  struct Level {
    std::string attribute = {};
    const LevelGeometry* stored = nullptr;
    /// That of `stored`, or one with blocks that are as small as the recipe wants them: each block
    /// of `stored` would be made from too many blocks.
    LevelGeometry geometry = {};
    std::unique_ptr<BlockMaker> maker = nullptr;
  };
  Level& level_of(From from, const std::string& attribute, const LevelGeometry& stored);
  std::vector<AttributeLevels> attributes_before(AttributeId attribute) const;
  void make(const BlockMaker& maker, std::uint64_t block, std::span<std::byte> records);

  const StoreCheck& check_;
  std::shared_ptr<const BlockMakers> makers_;
  Store* store_ = nullptr;
  std::array<Level, 2> levels_;  ///< [From] of the last call
  std::string refusal_;
  std::vector<std::byte> records_;
};

PLAIT_END_NAMESPACE
