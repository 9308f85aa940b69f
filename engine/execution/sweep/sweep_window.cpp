#include "execution/sweep/sweep_window.h"

#include <algorithm>
#include <span>

#include "execution/sweep/stencil.h"
#include "execution/sweep/sweep_chunks.h"
#include "paging/frame_pool.h"

namespace plait {

SweepWindow::SweepWindow(Store& store, const SweepPass& pass) : store_(store), pass_(pass) {
  view_.border_edges_ = store.base().border_edges();
  for (const LevelAccess& access : pass.accesses) {
    std::vector<Level>& levels = levels_.emplace_back();
    SweepView::Attribute& seen = view_.accesses_.emplace_back();
    seen.first_level = access.first_level;
    for (int number = access.first_level; number <= access.last_level; ++number) {
      LevelFile& file = store.level_file(access.attribute, number);
      Level& level = levels.emplace_back();
      level.file = &file;
      level.access = access.access;
      level.planned_in.assign(file.geometry.block_count(), 0);
      if (access.access != Access::kWrite && !file.traits.in_memory) {
        level.announced.assign(file.geometry.block_count(), false);
        file.backend->advise({0, file.geometry.block_count()}, Advice::kSequential);
      }
      seen.levels.push_back({&file.geometry, {}});
      seen.levels.back().starts.assign(file.geometry.block_count(), 0);
    }
  }
}

SweepWindow::~SweepWindow() {
  for (std::vector<Level>& levels : levels_)
    for (Level& level : levels)
      for (auto& [block, pin] : level.pinned) pin.abandon();
}

void SweepWindow::finish() noexcept {
  for (std::vector<Level>& levels : levels_)
    for (Level& level : levels) level.pinned.clear();
}

EdgeId SweepWindow::chunk_edges(int threads) const {
  int fewest_slots_log2 = kMostChunkEdgesLog2;
  for (const std::vector<Level>& levels : levels_)
    for (const Level& level : levels)
      fewest_slots_log2 = std::min(fewest_slots_log2, level.file->geometry.slots_per_block_log2());
  return plait::chunk_edges(fewest_slots_log2, threads);
}

void SweepWindow::plan(EdgeId first, EdgeId after) {
  ++plan_number_;
  const Topology mesh = store_.base().topology();
  for (std::size_t access = 0; access < levels_.size(); ++access) {
    std::vector<Level>& levels = levels_[access];
    if (levels.empty()) continue;
    for (Level& level : levels) level.planned.clear();
    // The finest level has the fewest slots in a block; the others' blocks are runs of its own.
    Level& finest = levels.back();
    for (EdgeId edge = first; edge < after; ++edge)
      for_each_edge_in_reach(mesh, edge, pass_.accesses[access].reach, [&](EdgeId needed) {
        finest.need(finest.file->geometry.block_of(needed), plan_number_);
      });
    for (Level& level : std::span(levels).first(levels.size() - 1))
      for (const std::uint64_t block : finest.planned)
        level.need(level.file->geometry.block_of(finest.file->geometry.first_edge(block)),
                   plan_number_);
  }
}

std::uint64_t SweepWindow::planned_bytes() const {
  std::uint64_t bytes = 0;
  for (const std::vector<Level>& levels : levels_)
    for (const Level& level : levels)
      bytes +=
          level.planned.size() * FramePool::frame_bytes(level.file->geometry.max_block_bytes());
  return bytes;
}

void SweepWindow::look_ahead(EdgeId first, EdgeId chunk) {
  constexpr EdgeId kRuns = 2 * Pager::kInFlight;
  const auto edge_count = static_cast<EdgeId>(store_.base().edge_count());
  const EdgeId end = edge_count - first > kRuns * chunk ? first + kRuns * chunk : edge_count;
  for (ahead_ = std::max(ahead_, first); ahead_ < end; ++ahead_)
    for (std::size_t access = 0; access < levels_.size(); ++access)
      for (Level& level : levels_[access])
        if (!level.announced.empty() && !announce(pass_.accesses[access], level, ahead_)) return;
}

/// False: the pager has no room at the moment.
bool SweepWindow::announce(const LevelAccess& access, Level& level, EdgeId edge) {
  bool taken = true;
  for_each_edge_in_reach(store_.base().topology(), edge, access.reach, [&](EdgeId needed) {
    const std::uint64_t block = level.file->geometry.block_of(needed);
    if (!taken || level.announced[block]) return;
    taken = session_.prefetch(*level.file, block);
    level.announced[block] = taken;
  });
  return taken;
}

void SweepWindow::advance() {
  for (std::size_t access = 0; access < levels_.size(); ++access)
    for (std::size_t i = 0; i < levels_[access].size(); ++i) {
      Level& level = levels_[access][i];
      std::erase_if(level.pinned, [&](const auto& pin) {
        if (level.planned_in[pin.first] == plan_number_) return false;
        view_.accesses_[access].levels[i].starts[pin.first] = 0;
        return true;
      });
    }
  for (std::size_t access = 0; access < levels_.size(); ++access)
    for (std::size_t i = 0; i < levels_[access].size(); ++i) {
      Level& level = levels_[access][i];
      std::vector<std::uintptr_t>& starts = view_.accesses_[access].levels[i].starts;
      for (const std::uint64_t block : level.planned) {
        if (starts[block] != 0) continue;
        level.pinned.emplace_back(block, session_.pin(*level.file, block, level.access));
        starts[block] =
            reinterpret_cast<std::uintptr_t>(level.pinned.back().second.bytes().data()) -
            level.file->geometry.block_offset(block);
      }
    }
}

}  // namespace plait
