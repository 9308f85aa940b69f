#include "plait/level_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

UnfinishedLevels::~UnfinishedLevels() {
  for (const Added& added : levels_) {
    --added.level->passes_under_way;
    added.level->left_unfinished = true;
  }
}

void UnfinishedLevels::add(LevelFile& level, Access access) {
  if (access == Access::kRead) return;
  levels_.push_back({&level, access});
  ++level.passes_under_way;
}

void UnfinishedLevels::finish() noexcept {
  for (const Added& added : levels_) {
    --added.level->passes_under_way;
    if (added.access == Access::kOverwrite) added.level->left_unfinished = false;
  }
  levels_.clear();
}

PLAIT_END_NAMESPACE
