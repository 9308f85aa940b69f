// Whether bytes are those that a damaged block had: they are if they get the same seal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/backend.h"
#include "plait/pager.h"
#include "plait/partial_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BlockProof {
 public:
  /// `options` are the store's backend's. The other arguments outlive this object.
  BlockProof(const BackendRegistry::Entry& backend, std::string_view options,
             PartialDirectory& scratch);
  ~BlockProof();

  const BackendRegistry::Entry& backend() const { return backend_; }
  std::unique_ptr<Volume> open_volume() const;

  /// What the level's file should hold for this block if `raw` is its content: stored bytes whose
  /// checksum is the one in the level's table. Nothing if they have another one. Valid until the
  /// next call. REQUIRES: `file` is the same object for all blocks of a level.
  std::optional<std::span<const std::byte>> stored_bytes(const LevelFile& file,
                                                         const AttributeSchema& schema,
                                                         std::uint64_t block,
                                                         std::span<const std::byte> raw);

 private:
  /// A level of the same identity, where blocks are sealed to be looked at.
  struct Model;
  Model& model_of(const LevelFile& file, const AttributeSchema& schema);

  const BackendRegistry::Entry& backend_;
  std::string options_;
  PartialDirectory& scratch_;
  std::unique_ptr<Model> model_;
  std::vector<std::byte> stored_;
};

PLAIT_END_NAMESPACE
