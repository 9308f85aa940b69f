// Joins two halves, compiled for each instruction set.
#include "execution/fused/half_merge.h"

#include <hwy/cache_control.h>

#include <cstdint>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "execution/fused/half_merge.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace plait::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Copies the bits of `own` where the mask has ones, and the bits of `other` elsewhere. REQUIRES
/// for `streaming`: `to` is aligned to a cache line, and the words fill whole lines.
HWY_INLINE void choose(const std::uint32_t* mask, const std::uint32_t* own,
                       const std::uint32_t* other, std::size_t words, bool streaming,
                       std::uint32_t* to) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t at = 0;
  const auto chosen = [&](auto tag, std::size_t i) HWY_ATTR {
    return hn::IfVecThenElse(hn::LoadU(tag, mask + i), hn::LoadU(tag, own + i),
                             hn::LoadU(tag, other + i));
  };
  if (streaming) {
    for (; at < words; at += lanes) hn::Stream(chosen(d, at), d, to + at);
    return;
  }
  for (; at + lanes <= words; at += lanes) hn::StoreU(chosen(d, at), d, to + at);
  const hn::CappedTag<std::uint32_t, 4> quad;
  for (; at + hn::Lanes(quad) <= words; at += hn::Lanes(quad))
    hn::StoreU(chosen(quad, at), quad, to + at);
  const hn::CappedTag<std::uint32_t, 1> one;
  for (; at < words; ++at) hn::StoreU(chosen(one, at), one, to + at);
}

void merge_piece(const HalfPiece& piece, std::size_t offset, std::span<const EdgeHalves> edges,
                 bool streaming) {
  for (const auto& [own_half, other_half, slots] : edges) {
    const std::byte *const own = own_half.piece(offset), *const other = other_half.piece(offset);
    for (const HalfPiece::PartOfSlot& part : piece.parts) {
      std::byte* const to = slots[part.level - 1] + part.in_slot;
      // Other parts are not streamed, because streaming parts of cache lines is slow.
      const bool whole_lines =
          part.bytes % kLineBytes == 0 && reinterpret_cast<std::uintptr_t>(to) % kLineBytes == 0;
      choose(piece.own_mask.data() + part.at / sizeof(std::uint32_t),
             reinterpret_cast<const std::uint32_t*>(own + part.at),
             reinterpret_cast<const std::uint32_t*>(other + part.at),
             part.bytes / sizeof(std::uint32_t), streaming && whole_lines,
             reinterpret_cast<std::uint32_t*>(to));
    }
  }
}

}  // namespace plait::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
PLAIT_BEGIN_PRIVATE_NAMESPACE

HWY_EXPORT(merge_piece);

void merge_piece(const HalfPiece& piece, std::size_t offset, std::span<const EdgeHalves> edges,
                 bool streaming) {
  HWY_DYNAMIC_DISPATCH(merge_piece)(piece, offset, edges, streaming);
}

void pack_border_slot(std::size_t record_bytes, int level, const std::byte* own, std::byte* slot) {
  const auto n = static_cast<std::size_t>(slot_side(level));
  for (std::size_t row = 0; row < n; ++row) {
    const std::size_t bytes = (n - row) * record_bytes;
    std::memcpy(slot, own, bytes);
    slot += bytes;
    own += n * record_bytes;
  }
}

void finish_streaming() { hwy::FlushStream(); }

PLAIT_END_NAMESPACE
#endif
