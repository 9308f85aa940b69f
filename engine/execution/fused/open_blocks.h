// The blocks that a fused pass is filling.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/store.h"

namespace plait {

/// Pins a block at its first slot and lets go of it after its last. One thread at a time.
class OpenBlocks {
 public:
  /// The `levels` levels after the base mesh's of these attributes.
  OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels);
  /// Abandons the blocks that are not filled.
  ~OpenBlocks();
  OpenBlocks(const OpenBlocks&) = delete;
  OpenBlocks& operator=(const OpenBlocks&) = delete;

  /// Pins the blocks of this edge's slots. Errors: those of Session::pin.
  void open(EdgeId edge);
  /// Where an output's slots of this edge are: slots[level - 1].
  /// REQUIRES: open(edge). May be called while others open and close.
  void find_slots(std::size_t output, EdgeId edge, std::uint64_t border_rank,
                  std::byte** slots) const;
  /// All slots of this edge are filled.
  void close(EdgeId edge);
  /// Whether slots lie in memory for good, so that a copy into them need not pass through caches.
  bool stays_in_memory() const { return stays_in_memory_; }

 private:
  struct Level {
    LevelFile* file = nullptr;
    std::vector<PinnedBlock> pins;         ///< [block]
    std::vector<std::uint64_t> offsets;    ///< [block]
    std::vector<std::uint32_t> remaining;  ///< [block] edges to come
  };

  Session session_;
  std::size_t level_count_;
  bool stays_in_memory_;
  std::vector<Level> levels_;  ///< output after output
};

}  // namespace plait
