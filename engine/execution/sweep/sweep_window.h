// The window of a sweep: the blocks that it has pinned.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/detail/pinned_level.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Pins the blocks that a run of edges needs, and releases all others. For one thread.
class SweepWindow {
 public:
  SweepWindow(Store& store, const SweepPass& pass);
  SweepWindow(const SweepWindow&) = delete;
  SweepWindow& operator=(const SweepWindow&) = delete;

  /// The number of edges between two moves of the window: see sweep_chunks.h.
  EdgeId chunk_edges(int threads) const;

  /// Must be called before the first look_ahead() or advance().
  void open(const SessionOptions& options) {
    session_ = StoreAccess::open_session(store_, options);
  }

  /// Finds the blocks that the edges [first, after) need. The next advance() pins them.
  void plan(EdgeId first, EdgeId after);
  /// Prefetches blocks for the edges from `first` on, until the session has no free frame, but at
  /// most for a few runs of `chunk` edges.
  void look_ahead(EdgeId first, EdgeId chunk);
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
  Session session_;
  std::vector<PinnedLevel> levels_;  ///< for each access, from coarse to fine
  std::vector<std::size_t>
      first_of_;                    ///< [access] index of its first level in levels_; then the end
  std::vector<EdgeId> ahead_ = {};  ///< [level] the blocks of all edges before are prefetched
  SweepView view_;
};

PLAIT_END_NAMESPACE
