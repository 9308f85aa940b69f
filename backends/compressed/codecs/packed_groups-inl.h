// The loops of packed_groups.h. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_CODECS_PACKED_GROUPS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_CODECS_PACKED_GROUPS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_CODECS_PACKED_GROUPS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_CODECS_PACKED_GROUPS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "compressed/codecs/packed_groups.h"

HWY_BEFORE_NAMESPACE();
namespace plait::packed_groups::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kGroupBytes = kGroupWords * sizeof(std::uint32_t);

using Tag = hn::CappedTag<std::uint32_t, kGroupWords>;
constexpr std::size_t kLanes = hn::MaxLanes(Tag());

#if HWY_TARGET != HWY_SCALAR
constexpr bool kHasWideVectors = kLanes == 8 || kLanes == 16;
#else
constexpr bool kHasWideVectors = false;
#endif

/// The bytes behind a group's begin that may be read: two halves of 32 bytes, of which the second
/// begins behind the first one's bits; or 8 bytes from the byte on where the last word begins.
constexpr std::size_t kReadAhead = kHasWideVectors ? 64 : 68;

/// For each width: the word of 32 bits where the bits of a lane begin, the word that has the rest
/// of them, and how far they are shifted.
struct Places {
  alignas(64) std::uint32_t low[kMostBits + 1][kGroupWords] = {};
  alignas(64) std::uint32_t high[kMostBits + 1][kGroupWords] = {};
  alignas(64) std::uint32_t shift[kMostBits + 1][kGroupWords] = {};

  constexpr Places() {
    for (std::uint32_t width = 0; width <= kMostBits; ++width)
      for (std::uint32_t i = 0; i < kGroupWords; ++i) {
        const std::uint32_t bit = i % kLanes * width;
        low[width][i] = bit / 32;
        // Where no bits are left, the word does not matter.
        high[width][i] = std::min<std::uint32_t>(bit / 32 + 1, kLanes - 1);
        shift[width][i] = bit % 32;
      }
  }
};

constexpr std::uint32_t mask_of(std::uint32_t width) noexcept {
  return static_cast<std::uint32_t>((std::uint64_t{1} << width) - 1);
}

inline void unpack_group(const std::byte* packed, std::uint32_t width, std::byte* words) noexcept {
  if constexpr (kHasWideVectors) {
    static constexpr Places kPlaces;
    const Tag d;
    const auto low = hn::IndicesFromVec(d, hn::Load(d, kPlaces.low[width]));
    const auto high = hn::IndicesFromVec(d, hn::Load(d, kPlaces.high[width]));
    const auto shift = hn::Load(d, kPlaces.shift[width]);
    const auto rest = hn::Sub(hn::Set(d, 31), shift);
    const auto mask = hn::Set(d, mask_of(width));
    for (std::size_t i = 0; i < kGroupWords; i += kLanes) {
      const std::size_t begin = i * width / 8;
      const auto bits = hn::LoadU(d, reinterpret_cast<const std::uint32_t*>(packed + begin));
      // Two steps to the left, because one step of 32 bits is not defined.
      const auto above = hn::Shl(hn::ShiftLeft<1>(hn::TableLookupLanes(bits, high)), rest);
      const auto below = hn::Shr(hn::TableLookupLanes(bits, low), shift);
      hn::StoreU(hn::And(hn::Or(below, above), mask), d,
                 reinterpret_cast<std::uint32_t*>(words + i * sizeof(std::uint32_t)));
    }
  } else {
    const std::uint32_t mask = mask_of(width);
    std::size_t bit = 0;
    for (std::size_t i = 0; i < kGroupWords; ++i, bit += width) {
      std::uint64_t bits;
      std::memcpy(&bits, packed + bit / 8, sizeof bits);
      const auto word = static_cast<std::uint32_t>(bits >> bit % 8) & mask;
      std::memcpy(words + i * sizeof word, &word, sizeof word);
    }
  }
}

/// How many bits the largest word of a group needs, from 0 to 32.
inline std::uint32_t width_of(const std::byte* words) noexcept {
  const Tag d;
  auto all = hn::Zero(d);
  for (std::size_t i = 0; i < kGroupWords; i += kLanes)
    all = hn::Or(all, hn::LoadU(d, reinterpret_cast<const std::uint32_t*>(words) + i));
  alignas(64) std::uint32_t lanes[kLanes];
  hn::Store(all, d, lanes);
  std::uint32_t any = 0;
  for (const std::uint32_t lane : lanes) any |= lane;
  return static_cast<std::uint32_t>(std::bit_width(any));
}

/// The width is known to the compiler, so all shifts are.
template <std::size_t kWidth>
void pack_group(const std::byte* words, std::byte* packed) {
  std::uint64_t bits = 0;
  std::size_t filled = 0;
#pragma GCC unroll 16
  for (std::size_t i = 0; i < kGroupWords; ++i) {
    std::uint32_t word;
    std::memcpy(&word, words + i * sizeof word, sizeof word);
    bits |= static_cast<std::uint64_t>(word) << filled;
    filled += kWidth;
    if (filled >= 32) {
      const auto full = static_cast<std::uint32_t>(bits);
      std::memcpy(packed, &full, sizeof full);
      packed += sizeof full;
      bits >>= 32;
      filled -= 32;
    }
  }
  if constexpr (kWidth % 2 == 1) {  // half a word is left
    const auto half = static_cast<std::uint16_t>(bits);
    std::memcpy(packed, &half, sizeof half);
  }
}

template <std::size_t... kWidths>
constexpr auto packers_of(std::index_sequence<kWidths...>) {
  return std::array{&pack_group<kWidths>...};
}

inline void group_widths(const std::byte* words, std::size_t groups, std::uint32_t* widths) {
  for (std::size_t group = 0; group < groups; ++group)
    widths[group] = width_of(words + group * kGroupBytes);
}

inline void pack(const std::byte* words, std::size_t groups, const std::uint32_t* widths,
                 std::byte* packed) {
  static constexpr auto kPackers = packers_of(std::make_index_sequence<kMostBits + 1>());
  for (std::size_t group = 0; group < groups; ++group) {
    kPackers[widths[group]](words + group * kGroupBytes, packed);
    packed += packed_bytes(kGroupWords, widths[group]);
  }
}

inline void unpack(const std::byte* packed, std::size_t bytes, const std::uint32_t* widths,
                   std::size_t groups, std::byte* words) {
  const std::byte* const end = packed + bytes;
  std::size_t group = 0;
  for (; group < groups && static_cast<std::size_t>(end - packed) >= kReadAhead; ++group) {
    unpack_group(packed, widths[group], words + group * kGroupBytes);
    packed += packed_bytes(kGroupWords, widths[group]);
  }
  if (group == groups) return;
  // The last bytes are read from a copy, behind which there is room.
  std::array<std::byte, 2 * kReadAhead> tail{};
  std::copy(packed, end, tail.begin());
  packed = tail.data();
  for (; group < groups; ++group) {
    unpack_group(packed, widths[group], words + group * kGroupBytes);
    packed += packed_bytes(kGroupWords, widths[group]);
  }
}

}  // namespace plait::packed_groups::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_CODECS_PACKED_GROUPS_INL_H
