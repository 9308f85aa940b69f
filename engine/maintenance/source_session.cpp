#include "maintenance/source_session.h"

#include <array>

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
  constexpr std::uint64_t kBlocks = Pager::kInFlight + 2;  // one is pinned, one has just been
  return store.open_session({.share_bytes = kBlocks * level.geometry.max_block_bytes()});
}

PLAIT_END_NAMESPACE
