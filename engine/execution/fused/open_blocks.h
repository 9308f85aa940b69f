// The blocks that a fused pass is filling.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/pinned_level.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Pins a block before its first slot is filled and releases the block after its last. One thread
/// at a time. If an exception destroys this object, the blocks that are not full are abandoned.
class OpenBlocks {
 public:
  /// The `levels` levels after the base mesh's of these attributes.
  OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels);
  OpenBlocks(const OpenBlocks&) = delete;
  OpenBlocks& operator=(const OpenBlocks&) = delete;

  /// Pins the blocks of these edges' slots. Errors: those of Session::pin_many.
  void open(std::span<const EdgeId> edges);
  /// Where an output's slots of this edge are: slots[level - 1].
  /// REQUIRES: open() had this edge. May be called while other threads open and close.
  void find_slots(std::size_t output, EdgeId edge, std::byte** slots) const;
  /// All slots of these edges are filled.
  void close(std::span<const EdgeId> edges);
  /// Whether slots lie in memory for good, so that a copy into them need not pass through caches.
  bool stays_in_memory() const { return stays_in_memory_; }

 private:
  Session session_;
  std::size_t level_count_;
  bool stays_in_memory_;
  std::vector<PinnedLevel> levels_;                  ///< output after output
  std::vector<std::vector<std::uint32_t>> to_fill_;  ///< [of levels_][block] slots
};

PLAIT_END_NAMESPACE
