// What a pass writes to must not be committed before the pass has ended.
#pragma once

#include <ranges>
#include <utility>
#include <vector>

#include "plait/pager.h"

namespace plait {

/// Marks levels as unfinished, and takes the mark away when the pass says that it has ended; if the
/// pass never says so, because it was cancelled or failed, they stay unfinished. A pass that
/// overwrites a level whole also ends what an earlier one left. In the thread that runs the pass.
class LevelsBeingWritten {
 public:
  /// Nothing is marked for Access::kRead.
  void add(LevelFile& level, Access access) {
    if (access == Access::kRead) return;
    levels_.emplace_back(&level, level.unfinished && access == Access::kUpdate);
    level.unfinished = true;
  }
  void finish() noexcept {
    // A level that was added twice gets back what it was at first.
    for (const auto& [level, unfinished_before] : std::views::reverse(levels_))
      level->unfinished = unfinished_before;
    levels_.clear();
  }

 private:
  std::vector<std::pair<LevelFile*, bool>> levels_;
};

}  // namespace plait
