#include "plait/level_file.h"

#include <fmt/format.h>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void check_not_fixed(const LevelFile& level) {
  if (level.is_derived)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: expected an attribute that is stored, found one that is "
                            "computed when it is read; change what it is computed from, or store "
                            "it first (plait convert --compress ATTRIBUTE=PIPELINE)",
                            level.path.native()));
  if (level.is_fixed)
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: expected a level that no other level is encoded from; "
                            "write to a new attribute, or convert the store to a pipeline "
                            "without prediction first (plait convert --compress fast)",
                            level.path.native()));
}

UnfinishedLevels::~UnfinishedLevels() {
  for (const Added& added : levels_) {
    --added.level->passes_under_way;
    added.level->left_unfinished = true;
  }
}

void UnfinishedLevels::add(LevelFile& level, Access access) {
  if (access == Access::kRead) return;
  check_not_fixed(level);
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
