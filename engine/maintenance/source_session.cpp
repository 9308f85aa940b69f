#include "maintenance/source_session.h"

#include <algorithm>
#include <array>

#include "paging/frame_pool.h"
#include "plait/backend.h"
#include "plait/pager.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool needs_others(const LevelFile& level) {
  if (level.is_derived) return true;
  std::array<ContextBlock, kMostContextBlocks> needed;
  return level.geometry.block_count() > 0 && level.backend->context(0, needed) > 0;
}

}  // namespace

Session open_source_session(const Store& store, const LevelFile& level) {
  if (needs_others(level)) return store.open_session();
  constexpr std::uint64_t kBlocks = Pager::kInFlight + 2;  // one is pinned, one was before
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  const std::uint64_t half = store.pager().budget_bytes() / 2;
  return store.open_session({.share_bytes = std::min(kBlocks * frame_bytes, half)});
}

PLAIT_END_NAMESPACE
