#include "paging/pin_batch.h"

#include "paging/frame_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t PinBatch::frame_bytes() const noexcept {
  std::uint64_t bytes = 0;
  for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
    bool known = false;
    for (auto earlier = entries_.begin(); earlier != entry && !known; ++earlier)
      known = earlier->level == entry->level && earlier->block == entry->block;
    if (!known) bytes += FrameTable::frame_bytes(*entry->level);
  }
  return bytes;
}

PLAIT_END_NAMESPACE
