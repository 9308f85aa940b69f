// The window of a sweep: the blocks that it has pinned.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "plait/detail/pinned_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// The edges that a kernel may access when it works on one edge.

/// Calls visit(EdgeId) for the edges within `reach` of `edge`, some of them more than once.
template <class Visit>
void for_each_edge_in_reach(const Topology& mesh, EdgeId edge, Reach reach, Visit visit) {
  visit(edge);
  if (reach == Reach::kOwn) return;
  for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other}) {
    if (!side.exists()) continue;
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(side.face(), (side.side() + turn) % 3);
      visit(mesh.face_edges[outer.face()][static_cast<std::size_t>(outer.side())]);
      if (reach != Reach::kRing) continue;
      const FaceSide beyond = mesh.across(outer);
      if (!beyond.exists()) continue;
      for (const EdgeId further : mesh.face_edges[beyond.face()]) visit(further);
    }
  }
}

// How many edges a sweep works on between two moves of its window.

constexpr int kMostChunkEdgesLog2 = 12;

/// The number of slots in a block of the finest level, but enough edges for every thread, as long
/// as the window does not grow. `fewest_slots_log2` belongs to the level with the fewest slots in
/// a block.
inline EdgeId chunk_edges(int fewest_slots_log2, int threads) {
  constexpr EdgeId kMinEdgesPerThread = 8;
  EdgeId wanted = 1;
  while (wanted < kMinEdgesPerThread * static_cast<EdgeId>(threads)) wanted *= 2;
  return std::max(EdgeId{1} << std::min(fewest_slots_log2, kMostChunkEdgesLog2), wanted);
}

/// Pins the blocks that a run of edges needs, and releases all others. For one thread.
class SweepWindow {
 public:
  SweepWindow(Store& store, const SweepPass& pass);
  SweepWindow(const SweepWindow&) = delete;
  SweepWindow& operator=(const SweepWindow&) = delete;

  /// The number of edges between two moves of the window: see chunk_edges() above.
  EdgeId chunk_edges(int threads) const;
  /// The same for moves by whole runs of blocks: at least chunk_edges(), by a power of two.
  EdgeId run_edges(int threads) const;

  /// Must be called before the first look_ahead() or advance().
  void open(const SessionOptions& options) {
    session_ = StoreAccess::open_session(store_, options);
  }

  /// Finds the blocks that the edges [first, after) need. The next advance() pins them.
  void plan(EdgeId first, EdgeId after);
  /// Prefetches blocks for the edges from `first` on, until the session has no free frame, but at
  /// most for a few runs of `run_edges` edges.
  void look_ahead(EdgeId first, EdgeId run_edges);
  /// Releases all blocks that are not planned, then pins the planned ones.
  void advance();

  const SweepView& view() const { return view_; }

 private:
  bool announce(PinnedLevel& level, Reach reach, EdgeId edge);
  std::span<PinnedLevel> levels_of(std::size_t access) {
    return std::span(levels_).subspan(first_of_[access], first_of_[access + 1] - first_of_[access]);
  }

  Store& store_;
  const SweepPass& pass_;
  bool has_depths_;
  Session session_;
  std::vector<PinnedLevel> levels_;  ///< for each access, from coarse to fine
  std::vector<std::size_t>
      first_of_;                    ///< [access] index of its first level in levels_; then the end
  std::vector<EdgeId> ahead_ = {};  ///< [level] the blocks of all edges before are prefetched
  SweepView view_;
};

PLAIT_END_NAMESPACE
