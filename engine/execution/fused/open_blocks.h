// The blocks that a fused pass is filling.
//
// Nothing here is locked. A thread pins the blocks that it needs and that nobody has pinned yet,
// and then tells their addresses. If two threads pin the same block, the first one to tell keeps
// its pin for all, and the other one ends its own. A block stays pinned until its last slot is
// filled. So a thread that finds a block pinned may use it until it has filled its own slots there,
// without another count.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/detail/level_file.h"
#include "plait/extend/session.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Pins a block before its first slot is filled and releases the block after its last. Threads:
/// shared. If an exception destroys this object, the blocks that are not full are abandoned.
class OpenBlocks {
 public:
  /// The `levels` levels after the base mesh's of these attributes.
  OpenBlocks(Store& store, std::span<const AttributeId> attributes, int levels);
  ~OpenBlocks();
  OpenBlocks(const OpenBlocks&) = delete;
  OpenBlocks& operator=(const OpenBlocks&) = delete;

  /// Pins the blocks of these edges' slots, which the caller will fill. Errors: those of
  /// Session::pin_many.
  void open(std::span<const EdgeId> edges);
  /// Where an output's slots of this edge are: slots[level - 1].
  /// REQUIRES: open() had this edge.
  void find_slots(std::size_t output, EdgeId edge, std::byte** slots) const;
  /// All slots of these edges are filled.
  void close(std::span<const EdgeId> edges);
  /// Whether slots lie in memory for good, so that a copy into them need not pass through caches.
  bool stays_in_memory() const { return stays_in_memory_; }

 private:
  struct Block {
    /// The address of the block in its frame minus its offset in the level, so that adding an
    /// offset gives an address; 0 while the block is not pinned.
    std::atomic<std::uintptr_t> start = 0;
    std::atomic<std::uint32_t> to_fill = 0;  ///< slots
    PinnedBlock pinned;  ///< for the thread that has set `start`, then for who fills the last slot
  };
  struct Level {
    AttributeId attribute;
    int number;
    LevelFile* file;
    std::unique_ptr<Block[]> blocks;
  };

  Session session_;
  std::size_t level_count_;
  bool stays_in_memory_;
  const StoreAccess::BlockFilled& filled_;
  std::vector<Level> levels_;  ///< output after output
  int exceptions_;             ///< when this object was made
};

PLAIT_END_NAMESPACE
