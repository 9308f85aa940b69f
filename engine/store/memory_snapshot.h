// The last commit of a store in memory: what roll_back() brings back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Made by each commit of a store in memory. Blocks keep their committed bytes themselves, from
/// their first change on (blocks/kept_blocks.h).
struct MemorySnapshot {
  explicit MemorySnapshot(Store::Implementation& state);

  /// Takes levels that are removed from the store, as far as the commit has them. REQUIRES: the
  /// pager does not know them any more.
  void take(std::vector<std::unique_ptr<LevelFile>> levels);
  /// Gives the store its committed content.
  void restore(Store::Implementation& state);

 private:
  struct CommittedAttribute {
    AttributeInfo info;
    AttributeRecord record;
    BaseRecords base_bytes;
  };
  Provenance provenance_;
  std::uint32_t next_number_;
  std::vector<CommittedAttribute> attributes_;
  std::vector<AttributeSchema> face_infos_;
  std::vector<Store::Implementation::FaceAttribute> face_attributes_;
  Texts texts_;
  std::vector<std::unique_ptr<LevelFile>> removed_;
};

PLAIT_END_NAMESPACE
