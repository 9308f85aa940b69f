#include "execution/pin_needs.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "execution/sweep/sweep_window.h"
#include "paging/frame_pool.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Counts the blocks of one access that a chunk of edges, or a face, needs.
class NeededBlocks {
 public:
  NeededBlocks(const Store& store, AccessedGeometries access)
      : reach_(access.reach), has_depths_(store.base().depths() != nullptr) {
    for (LevelGeometry& geometry : access.levels) levels_.push_back({std::move(geometry), {}});
    for (Level& level : levels_) level.needed_by.assign(level.geometry.block_count(), 0);
  }

  Reach reach() const { return reach_; }
  /// Of the finest level, which has the fewest slots in a block. REQUIRES: there are levels.
  int slots_per_block_log2() const { return levels_.back().geometry.slots_per_block_log2(); }

  void begin_stencil() {
    ++stencil_;
    bytes_ = 0;
  }
  void need(EdgeId edge) {
    // A block of a finer level has the edges of a part of one block of each coarser level. So if
    // the stencil needs that block already, it needs those of the coarser levels too. In a store
    // with depths it may have the edges of many coarser blocks.
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
      if (has_depths_ && !level->geometry.has_slot(edge)) continue;
      std::uint64_t& needed_by = level->needed_by[level->geometry.block_of(edge)];
      if (needed_by == stencil_) {
        if (has_depths_) continue;
        return;
      }
      needed_by = stencil_;
      bytes_ += FramePool::frame_bytes(level->geometry.max_block_bytes());
    }
  }
  std::uint64_t bytes() const { return bytes_; }

 private:
  struct Level {
    LevelGeometry geometry;
    std::vector<std::uint64_t> needed_by;  ///< [block] number of the last stencil that needs it
  };
  Reach reach_;
  bool has_depths_;
  std::vector<Level> levels_;
  std::uint64_t stencil_ = 0, bytes_ = 0;
};

AccessedGeometries geometries_of(const Store& store, const AccessedLevels& access) {
  AccessedGeometries result{{}, access.reach};
  for (int level = std::max(access.first_level, store.base_level() + 1); level <= access.last_level;
       ++level)
    result.levels.push_back(StoreAccess::geometry(store, access.record_bytes, level));
  return result;
}

}  // namespace

std::uint64_t window_needs(const Store& store, std::vector<AccessedGeometries> accesses,
                           int threads) {
  const Topology mesh = store.base().topology();
  std::vector<NeededBlocks> needed;
  int fewest_slots_log2 = kMostChunkEdgesLog2;
  for (AccessedGeometries& access : accesses) {
    if (access.levels.empty()) continue;
    needed.emplace_back(store, std::move(access));
    fewest_slots_log2 = std::min(fewest_slots_log2, needed.back().slots_per_block_log2());
  }
  const EdgeRange edges = StoreAccess::edges(store);
  const std::uint64_t chunk = chunk_edges(fewest_slots_log2, threads);
  std::uint64_t most = 0;
  for (std::uint64_t first = edges.first; first < edges.after; first += chunk) {
    std::uint64_t bytes = 0;
    for (NeededBlocks& blocks : needed) {
      blocks.begin_stencil();
      for (std::uint64_t edge = first; edge < std::min<std::uint64_t>(first + chunk, edges.after);
           ++edge)
        for_each_edge_in_reach(mesh, static_cast<EdgeId>(edge), blocks.reach(),
                               [&](EdgeId reached) { blocks.need(reached); });
      bytes += blocks.bytes();
    }
    most = std::max(most, bytes);
  }
  return most;
}

std::uint64_t sweep_needs(const Store& store, std::span<const AccessedLevels> accesses,
                          int threads) {
  std::vector<AccessedGeometries> geometries;
  for (const AccessedLevels& access : accesses) geometries.push_back(geometries_of(store, access));
  return window_needs(store, std::move(geometries), threads);
}

std::uint64_t patch_needs(const Store& store, const AccessedLevels& access) {
  const Topology mesh = store.base().topology();
  NeededBlocks blocks(store, geometries_of(store, access));
  std::uint64_t most = 0;
  for (FaceId face = 0; face < mesh.faces.size(); ++face) {
    blocks.begin_stencil();
    // The reach of the face is the union of what its edges reach.
    for (const EdgeId edge : mesh.face_edges[face])
      for_each_edge_in_reach(mesh, edge, access.reach,
                             [&](EdgeId reached) { blocks.need(reached); });
    most = std::max(most, blocks.bytes());
  }
  return most;
}

PLAIT_END_NAMESPACE
