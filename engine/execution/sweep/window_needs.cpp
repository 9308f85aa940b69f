#include "plait/window_needs.h"

#include <algorithm>
#include <vector>

#include "execution/sweep/stencil.h"
#include "execution/sweep/sweep_chunks.h"
#include "paging/frame_pool.h"
#include "plait/level_geometry.h"

namespace plait {
namespace {

/// The blocks of one access that are needed at one place.
class NeededBlocks {
 public:
  NeededBlocks(const Store& store, const WindowAccess& access) : reach_(access.reach) {
    const BaseMesh& base = store.base();
    for (int level = std::max(access.first_level, store.base_level() + 1);
         level <= access.last_level; ++level)
      levels_.push_back(
          {LevelGeometry(base.slot_shapes(), relative_to_base(level, store.base_level()),
                         access.record_bytes, store.options().block_bytes),
           {}});
    for (Level& level : levels_) level.needed_at.assign(level.geometry.block_count(), 0);
  }

  Reach reach() const { return reach_; }
  /// -1 without levels. The finest level has the fewest.
  int slots_per_block_log2() const {
    return levels_.empty() ? -1 : levels_.back().geometry.slots_per_block_log2();
  }

  void begin_place() {
    ++place_;
    bytes_ = 0;
  }
  void need(EdgeId edge) {
    // The finest level first: whose block is known has all coarser ones too, for these are unions.
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
      std::uint64_t& needed_at = level->needed_at[level->geometry.block_of(edge)];
      if (needed_at == place_) return;
      needed_at = place_;
      bytes_ += FramePool::frame_bytes(level->geometry.max_block_bytes());
    }
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  struct Level {
    LevelGeometry geometry;
    std::vector<std::uint64_t> needed_at;  ///< [block] the last place that did
  };
  Reach reach_;
  std::vector<Level> levels_;
  std::uint64_t place_ = 0, bytes_ = 0;
};

}  // namespace

std::uint64_t sweep_needs(const Store& store, std::span<const WindowAccess> accesses, int threads) {
  const Topology mesh = store.base().topology();
  std::vector<NeededBlocks> needed;
  int fewest_slots_log2 = kMostChunkEdgesLog2;
  for (const WindowAccess& access : accesses) {
    needed.emplace_back(store, access);
    if (needed.back().slots_per_block_log2() < 0)
      needed.pop_back();
    else
      fewest_slots_log2 = std::min(fewest_slots_log2, needed.back().slots_per_block_log2());
  }
  const std::uint64_t edge_count = mesh.edges.size();
  const std::uint64_t chunk = chunk_edges(fewest_slots_log2, threads);
  std::uint64_t most = 0;
  for (std::uint64_t first = 0; first < edge_count; first += chunk) {
    std::uint64_t bytes = 0;
    for (NeededBlocks& blocks : needed) {
      blocks.begin_place();
      for (std::uint64_t edge = first; edge < std::min(first + chunk, edge_count); ++edge)
        for_each_edge_in_reach(mesh, static_cast<EdgeId>(edge), blocks.reach(),
                               [&](EdgeId reached) { blocks.need(reached); });
      bytes += blocks.bytes();
    }
    most = std::max(most, bytes);
  }
  return most;
}

std::uint64_t patch_needs(const Store& store, const WindowAccess& access) {
  const Topology mesh = store.base().topology();
  NeededBlocks blocks(store, access);
  std::uint64_t most = 0;
  for (FaceId face = 0; face < mesh.faces.size(); ++face) {
    blocks.begin_place();
    // What the face's edges reach, each of them together, is what the face reaches.
    for (const EdgeId edge : mesh.face_edges[face])
      for_each_edge_in_reach(mesh, edge, access.reach,
                             [&](EdgeId reached) { blocks.need(reached); });
    most = std::max(most, blocks.bytes());
  }
  return most;
}

}  // namespace plait
