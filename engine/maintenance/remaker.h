// Makes blocks and base records of a damaged store again, and proves that they are the lost ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/unpublished.h"
#include "plait/extend/backend.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/check_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For one thread.
class Remaker {
 public:
  /// The arguments outlive this object. `makers` may be null. `scratch` is a directory for files of
  /// this object's own, which makes it when it needs it.
  Remaker(const StoreCheck& check, std::shared_ptr<const BlockMakers> makers,
          const BackendRegistry& backends, UnpublishedDirectory& scratch)
      : check_(check), makers_(std::move(makers)), backends_(backends), scratch_(scratch) {}

  /// REQUIRES: the description of the store is whole.
  const RegisteredBackend& backend() const { return backends_.find(check_.options.backend); }
  const AttributeInfo& info_of(const std::string& attribute) const;
  /// From now on, blocks are made from the other attributes of the store too. `store` is the one
  /// that was checked, and outlives this object.
  void read_from(Store& store) { store_ = &store; }

  /// Makes the block from the base mesh, or else from other attributes. Returns it as the backend
  /// stores it, if that has the checksum in the level's table. Valid until the next call. REQUIRES:
  /// `level` is the same object for all blocks of a level. Errors: those of reading blocks, but
  /// kCorruption.
  std::optional<std::span<const std::byte>> block(const std::string& attribute,
                                                  const LevelFile& level, std::uint64_t block);
  /// The records of the block that the last call returned.
  const std::vector<std::byte>& records() const { return records_; }
  /// The records of the base vertices from the base mesh, without a proof.
  std::optional<std::span<const std::byte>> base_records(const std::string& attribute);
  /// Why the last call returned nothing.
  const std::string& refusal() const { return refusal_; }

 private:
  static constexpr char kModelName[] = "sealed";
  /// How blocks of the level of the last call are made.
  struct Recipe {
    const LevelGeometry* stored = nullptr;  ///< of the level
    std::string refusal = {};
    /// That of `stored`, or one with blocks that are as small as the maker wants them: each block
    /// of `stored` would be made from too many blocks.
    LevelGeometry geometry = {};
    std::unique_ptr<BlockMaker> maker = nullptr;
  };
  Recipe& recipe_of(bool from_mesh, const std::string& attribute, const LevelGeometry& stored);
  std::vector<AttributeLevels> attributes_before(AttributeId attribute) const;
  /// Makes records_. Returns false if nothing makes them.
  bool make(bool from_mesh, const std::string& attribute, const LevelGeometry& geometry,
            std::uint64_t block);
  /// The stored bytes of records_, if they have the checksum in the level's table.
  std::optional<std::span<const std::byte>> proven(const AttributeSchema& schema,
                                                   const LevelFile& level, std::uint64_t block);

  const StoreCheck& check_;
  std::shared_ptr<const BlockMakers> makers_;
  const BackendRegistry& backends_;
  UnpublishedDirectory& scratch_;
  Store* store_ = nullptr;
  std::array<Recipe, 2> recipes_;  ///< [from_mesh]
  // A level in the scratch directory, with the identity of the store's level. Blocks are written
  // there to learn their stored bytes and checksums.
  const LevelFile* model_of_ = nullptr;
  BlockTable table_;
  std::unique_ptr<Volume> volume_;
  std::unique_ptr<Backend> model_;
  std::string refusal_;
  std::vector<std::byte> records_, stored_;
};

PLAIT_END_NAMESPACE
