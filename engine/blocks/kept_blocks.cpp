#include "blocks/kept_blocks.h"

#include <algorithm>
#include <cstring>
#include <span>

PLAIT_BEGIN_PRIVATE_NAMESPACE

KeptBlocks::KeptBlocks(const LevelFile& level)
    : entries_(level.table.entries().begin(), level.table.entries().end()),
      is_kept_(entries_.size()) {}

void KeptBlocks::keep(LevelFile& level, std::uint64_t block) {
  const std::scoped_lock lock(mutex_);
  if (is_kept_[block]) return;
  Kept kept{block, {}};
  if (entries_[block].encoding != BlockEncoding::kNeverWritten) {
    const std::byte* const bytes = level.backend->address(block);
    kept.bytes.assign(bytes, bytes + level.geometry.block_bytes(block));
  }
  kept_.push_back(std::move(kept));
  is_kept_[block] = true;
}

void KeptBlocks::restore(LevelFile& level) noexcept {
  for (const Kept& kept : kept_) {
    std::byte* const bytes = level.backend->address(kept.block);
    // A block that was never written reads as zeros.
    std::memset(bytes, 0, static_cast<std::size_t>(level.geometry.block_bytes(kept.block)));
    std::ranges::copy(kept.bytes, bytes);
  }
  std::ranges::copy(entries_, level.table.entries().begin());
  kept_.clear();
  is_kept_.assign(is_kept_.size(), false);
}

PLAIT_END_NAMESPACE
