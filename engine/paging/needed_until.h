// paging/needed_until.h: how long a pass over the edges needs a block from which others are
// decoded.
#pragma once

#include <vector>

#include "plait/detail/level_file.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct NeededLevel {
  const LevelFile* level;
  /// [block] the last edge of the blocks that are decoded from it, or from blocks that are decoded
  /// from it. Empty if no block is decoded from the level.
  std::vector<EdgeId> until;
};

/// Finds `until` of all levels of a store. Asks the backends for the context of as few blocks as
/// tell it: where blocks of two levels of one attribute have the same edges, those of the finer one
/// need about what the others need. Errors: std::bad_alloc.
void find_needed_until(std::vector<NeededLevel>& levels);

PLAIT_END_NAMESPACE
