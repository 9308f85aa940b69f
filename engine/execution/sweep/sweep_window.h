// The blocks that a sweep holds at once.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/sweep.h"

namespace plait {

/// Pins what a run of edges needs and lets go of what it does not. One thread.
class SweepWindow {
 public:
  SweepWindow(Store& store, const SweepPass& pass);
  /// Abandons what is pinned, unless finish() was called.
  ~SweepWindow();
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
  /// Announces blocks that the edges from `first` on will need to the pager, as far as it takes
  /// them, but no more than for some runs of `chunk` edges.
  void look_ahead(EdgeId first, EdgeId chunk);
  /// Unpins what is not planned, then pins what is.
  void advance();

  /// All edges were worked on.
  void finish() noexcept;

  const SweepView& view() const { return view_; }

 private:
  struct Level {
    LevelFile* file = nullptr;
    Access access = Access::kRead;
    std::vector<std::uint32_t> planned_in;  ///< [block] number of the last plan that needs it
    std::vector<std::uint64_t> planned;     ///< blocks
    std::vector<bool> announced;            ///< [block]; empty: nothing to read
    std::vector<std::pair<std::uint64_t, PinnedBlock>> pinned;

    void need(std::uint64_t block, std::uint32_t plan) {
      if (planned_in[block] == plan) return;
      planned_in[block] = plan;
      planned.push_back(block);
    }
  };

  bool announce(const LevelAccess& access, Level& level, EdgeId edge);

  Store& store_;
  const SweepPass& pass_;
  Session session_;
  std::vector<std::vector<Level>> levels_;  ///< [access][level - first level]
  std::uint32_t plan_number_ = 0;
  EdgeId ahead_ = 0;  ///< the blocks of all edges before it were announced
  SweepView view_;
};

}  // namespace plait
