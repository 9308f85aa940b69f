#include "paging/level_cursor.h"

#include <algorithm>

#include "plait/extend/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void LevelCursor::move_to(EdgeId edge) {
  level_.begin_step();
  level_.release_rest();
  level_.need(edge);
  PinnedLevel::pin_needed(*session_, std::span(&level_, 1));
  const std::uint64_t next = geometry().block_of(edge) + 1;
  const std::uint64_t ahead = std::uint64_t{Pager::kInFlight} << level_.run_log2();
  const std::uint64_t end = std::min(geometry().block_count(), next + ahead);
  for (std::uint64_t block = next; block < end; ++block)
    if (!level_.announce(*session_, geometry().edge_after(block) - 1)) return;
}

PLAIT_END_NAMESPACE
