#include "maintenance/source_session.h"

#include <algorithm>

#include "paging/frame_pool.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Session open_source_session(const Store& store, const LevelFile& level) {
  if (needs_other_blocks(level)) return StoreAccess::open_session(store);
  constexpr std::uint64_t kBlocks = Pager::kInFlight + 2;  // one is pinned, one was before
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  const std::uint64_t half = StoreAccess::pager(store).budget_bytes() / 2;
  return StoreAccess::open_session(store, {.share_bytes = std::min(kBlocks * frame_bytes, half)});
}

PLAIT_END_NAMESPACE
