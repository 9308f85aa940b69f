// The blocks that a sweep holds at once.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/pinned_level.h"
#include "plait/sweep.h"

namespace plait {

/// Pins the blocks that a run of edges needs, and releases all others. One thread.
class SweepWindow {
 public:
  SweepWindow(Store& store, const SweepPass& pass);
  SweepWindow(const SweepWindow&) = delete;
  SweepWindow& operator=(const SweepWindow&) = delete;

  /// Edges that are worked on together: those of one block of the finest level, but enough of them
  /// to keep `threads` threads busy.
  EdgeId chunk_edges(int threads) const;

  /// Before the first look_ahead() or advance().
  void open(const SessionOptions& options) { session_ = store_.open_session(options); }

  /// Finds the blocks that the edges [first, after) need. The next advance() pins these.
  void plan(EdgeId first, EdgeId after);
  std::uint64_t planned_bytes() const;
  /// Announces blocks that the edges from `first` on will need, until the session takes no more,
  /// but for a few runs of `chunk` edges at most.
  void look_ahead(EdgeId first, EdgeId chunk);
  /// Releases the blocks that are not planned, then pins those that are.
  void advance();

  const SweepView& view() const { return view_; }

 private:
  bool announce(std::size_t access, EdgeId edge);
  std::span<PinnedLevel> levels_of(std::size_t access) {
    return std::span(levels_).subspan(first_of_[access], first_of_[access + 1] - first_of_[access]);
  }

  Store& store_;
  const SweepPass& pass_;
  Session session_;
  std::vector<PinnedLevel> levels_;    ///< access after access, from coarse to fine
  std::vector<std::size_t> first_of_;  ///< [access] its first in levels_, and the end
  EdgeId ahead_ = 0;                   ///< the blocks of all edges before it were announced
  SweepView view_;
};

}  // namespace plait
