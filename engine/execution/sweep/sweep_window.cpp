#include "execution/sweep/sweep_window.h"

#include <algorithm>

#include "plait/detail/level_file.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

SweepWindow::SweepWindow(Store& store, const SweepPass& pass)
    : store_(store), pass_(pass), has_depths_(store.base().depths() != nullptr) {
  for (const LevelAccess& access : pass.accesses) {
    first_of_.push_back(levels_.size());
    for (int number = access.first_level; number <= access.last_level; ++number) {
      LevelFile& file = StoreAccess::level_file(store, access.attribute, number);
      levels_.emplace_back(file, access.access);
      if (access.access != Access::kOverwrite && !file.traits.in_memory)
        file.backend->advise({0, file.geometry.block_count()}, Advice::kSequential);
    }
  }
  first_of_.push_back(levels_.size());
  for (std::size_t access = 0; access < pass.accesses.size(); ++access)
    view_.accesses_.push_back({pass.accesses[access].first_level, levels_of(access).data()});
}

EdgeId SweepWindow::chunk_edges(int threads) const {
  int fewest_slots_log2 = kMostChunkEdgesLog2;
  for (const PinnedLevel& level : levels_)
    fewest_slots_log2 = std::min(fewest_slots_log2, level.geometry().slots_per_block_log2());
  return plait::chunk_edges(fewest_slots_log2, threads);
}

EdgeId SweepWindow::run_edges(int threads) const {
  int fewest_slots_log2 = kMostChunkEdgesLog2;
  for (const PinnedLevel& level : levels_)
    fewest_slots_log2 = std::min(fewest_slots_log2, level.geometry().slots_per_block_log2() +
                                                        most_run_log2(level.geometry()));
  return std::max(plait::chunk_edges(fewest_slots_log2, threads), chunk_edges(threads));
}

void SweepWindow::plan(EdgeId first, EdgeId after) {
  const Topology mesh = store_.base().topology();
  for (PinnedLevel& level : levels_) level.begin_step();
  for (std::size_t access = 0; access < pass_.accesses.size(); ++access) {
    const std::span<PinnedLevel> levels = levels_of(access);
    if (levels.empty()) continue;
    PinnedLevel& finest = levels.back();
    if (has_depths_) {
      for (EdgeId edge = first; edge < after; ++edge)
        for_each_edge_in_reach(mesh, edge, pass_.accesses[access].reach, [&](EdgeId needed) {
          for (PinnedLevel& level : levels)
            if (level.geometry().has_slot(needed)) level.need(needed);
        });
      continue;
    }
    for (EdgeId edge = first; edge < after; ++edge)
      for_each_edge_in_reach(mesh, edge, pass_.accesses[access].reach,
                             [&](EdgeId needed) { finest.need(needed); });
    // The finest level has the fewest slots in a block, so its blocks need only few blocks of other
    // levels.
    for (PinnedLevel& level : levels.first(levels.size() - 1)) level.need_edges_of(finest);
  }
}

void SweepWindow::look_ahead(EdgeId first, EdgeId run_edges) {
  if (levels_.empty()) return;
  constexpr EdgeId kRuns = 2 * Pager::kInFlight;
  const EdgeId last = StoreAccess::edges(store_).after;
  const EdgeId end = last - first > kRuns * run_edges ? first + kRuns * run_edges : last;
  // Near edges first. A level whose block has to wait for another one does not stop the others.
  ahead_.resize(levels_.size());
  for (EdgeId& ahead : ahead_) ahead = std::max(ahead, first);
  std::vector<bool> stopped(levels_.size());
  while (true) {
    EdgeId edge = end;
    for (std::size_t i = 0; i < levels_.size(); ++i)
      if (!stopped[i]) edge = std::min(edge, ahead_[i]);
    if (edge == end) return;
    for (std::size_t access = 0; access < pass_.accesses.size(); ++access)
      for (std::size_t i = first_of_[access]; i < first_of_[access + 1]; ++i) {
        if (stopped[i] || ahead_[i] != edge) continue;
        stopped[i] = levels_[i].can_be_announced() &&
                     !announce(levels_[i], pass_.accesses[access].reach, edge);
        if (!stopped[i]) ++ahead_[i];
      }
  }
}

/// Returns false if the session has no free frame at the moment, or if a block has to wait for
/// another one.
bool SweepWindow::announce(PinnedLevel& level, Reach reach, EdgeId edge) {
  bool taken = true;
  for_each_edge_in_reach(store_.base().topology(), edge, reach, [&](EdgeId needed) {
    taken = taken && (!level.geometry().has_slot(needed) || level.announce(session_, needed));
  });
  return taken;
}

void SweepWindow::advance() {
  for (PinnedLevel& level : levels_) level.release_rest();
  PinnedLevel::pin_needed(session_, levels_);
}

PLAIT_END_NAMESPACE
