// Proves that bytes are those of a damaged block: they have the checksum in the block table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "io/unpublished.h"
#include "plait/extend/backend.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BlockProof {
 public:
  /// The arguments outlive this object.
  BlockProof(const RegisteredBackend& backend, UnpublishedDirectory& scratch);
  ~BlockProof();

  const RegisteredBackend& backend() const { return backend_; }
  std::unique_ptr<Volume> open_volume() const;

  /// Encodes `raw` as the level's backend stores this block, and returns the result if it has the
  /// checksum in the level's table. Otherwise returns nothing. The result is valid until the next
  /// call. REQUIRES: `file` is the same object for all blocks of a level.
  std::optional<std::span<const std::byte>> stored_bytes(const LevelFile& file,
                                                         const AttributeSchema& schema,
                                                         std::uint64_t block,
                                                         std::span<const std::byte> raw);

 private:
  /// A level in the scratch directory, with the identity of the store's level. Blocks are written
  /// there to learn their stored bytes and checksums.
  struct Model;
  Model& model_of(const LevelFile& file, const AttributeSchema& schema);

  const RegisteredBackend& backend_;
  UnpublishedDirectory& scratch_;
  std::unique_ptr<Model> model_;
  std::vector<std::byte> stored_;
};

PLAIT_END_NAMESPACE
