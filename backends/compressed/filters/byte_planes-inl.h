// The loops of byte_planes.h. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace plait::byte_planes::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Byte = std::uint8_t;

/// Numbers from `first` on, one by one.
template <std::size_t kWidth>
HWY_INLINE void split_rest(const Byte* numbers, std::size_t first, std::size_t count,
                           Byte* planes) {
  for (std::size_t plane = 0; plane < kWidth; ++plane)
    for (std::size_t i = first; i < count; ++i)
      planes[plane * count + i] = numbers[i * kWidth + plane];
}
template <std::size_t kWidth>
HWY_INLINE void join_rest(const Byte* planes, std::size_t first, std::size_t count, Byte* numbers) {
  for (std::size_t i = first; i < count; ++i)
    for (std::size_t plane = 0; plane < kWidth; ++plane)
      numbers[i * kWidth + plane] = planes[plane * count + i];
}

#if HWY_TARGET == HWY_SCALAR  // processors without vectors of bytes

HWY_INLINE void split2(const Byte* numbers, std::size_t count, Byte* planes) {
  split_rest<2>(numbers, 0, count, planes);
}
HWY_INLINE void join2(const Byte* planes, std::size_t count, Byte* numbers) {
  join_rest<2>(planes, 0, count, numbers);
}
HWY_INLINE void split4(const Byte* numbers, std::size_t count, Byte* planes) {
  split_rest<4>(numbers, 0, count, planes);
}
HWY_INLINE void join4(const Byte* planes, std::size_t count, Byte* numbers) {
  join_rest<4>(planes, 0, count, numbers);
}
HWY_INLINE void split8(const Byte* numbers, std::size_t count, Byte* planes) {
  split_rest<8>(numbers, 0, count, planes);
}
HWY_INLINE void join8(const Byte* planes, std::size_t count, Byte* numbers) {
  join_rest<8>(planes, 0, count, numbers);
}

#else

HWY_INLINE void split2(const Byte* numbers, std::size_t count, Byte* planes) {
  const hn::ScalableTag<Byte> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
    hn::Vec<decltype(d)> p0, p1;
    hn::LoadInterleaved2(d, numbers + 2 * i, p0, p1);
    hn::StoreU(p0, d, planes + i);
    hn::StoreU(p1, d, planes + count + i);
  }
  split_rest<2>(numbers, i, count, planes);
}
HWY_INLINE void join2(const Byte* planes, std::size_t count, Byte* numbers) {
  const hn::ScalableTag<Byte> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d))
    hn::StoreInterleaved2(hn::LoadU(d, planes + i), hn::LoadU(d, planes + count + i), d,
                          numbers + 2 * i);
  join_rest<2>(planes, i, count, numbers);
}

HWY_INLINE void split4(const Byte* numbers, std::size_t count, Byte* planes) {
  const hn::ScalableTag<Byte> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) {
    hn::Vec<decltype(d)> p0, p1, p2, p3;
    hn::LoadInterleaved4(d, numbers + 4 * i, p0, p1, p2, p3);
    hn::StoreU(p0, d, planes + i);
    hn::StoreU(p1, d, planes + count + i);
    hn::StoreU(p2, d, planes + 2 * count + i);
    hn::StoreU(p3, d, planes + 3 * count + i);
  }
  split_rest<4>(numbers, i, count, planes);
}
HWY_INLINE void join4(const Byte* planes, std::size_t count, Byte* numbers) {
  const hn::ScalableTag<Byte> d;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d))
    hn::StoreInterleaved4(hn::LoadU(d, planes + i), hn::LoadU(d, planes + count + i),
                          hn::LoadU(d, planes + 2 * count + i),
                          hn::LoadU(d, planes + 3 * count + i), d, numbers + 4 * i);
  join_rest<4>(planes, i, count, numbers);
}

// Numbers of 8 bytes are four pairs of bytes.
HWY_INLINE void split8(const Byte* numbers, std::size_t count, Byte* planes) {
  const hn::FixedTag<std::uint16_t, 8> pairs;
  const hn::FixedTag<std::int16_t, 8> small;
  const hn::FixedTag<Byte, 8> d;
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    HWY_ALIGN std::uint16_t words[32];
    std::memcpy(words, numbers + 8 * i, sizeof(words));
    hn::Vec<decltype(pairs)> p01, p23, p45, p67;
    hn::LoadInterleaved4(pairs, words, p01, p23, p45, p67);
    const auto store = [&](std::size_t plane, auto pair) HWY_ATTR {
      const auto low = hn::And(pair, hn::Set(pairs, 0xff)), high = hn::ShiftRight<8>(pair);
      hn::StoreU(hn::DemoteTo(d, hn::BitCast(small, low)), d, planes + plane * count + i);
      hn::StoreU(hn::DemoteTo(d, hn::BitCast(small, high)), d, planes + (plane + 1) * count + i);
    };
    store(0, p01);
    store(2, p23);
    store(4, p45);
    store(6, p67);
  }
  split_rest<8>(numbers, i, count, planes);
}
HWY_INLINE void join8(const Byte* planes, std::size_t count, Byte* numbers) {
  const hn::FixedTag<Byte, 16> d;
  const hn::FixedTag<std::uint16_t, 8> pairs;
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16) {
    const auto plane = [&](std::size_t which)
                           HWY_ATTR { return hn::LoadU(d, planes + which * count + i); };
    const auto p0 = plane(0), p1 = plane(1), p2 = plane(2), p3 = plane(3), p4 = plane(4),
               p5 = plane(5), p6 = plane(6), p7 = plane(7);
    HWY_ALIGN std::uint16_t words[64];
    hn::StoreInterleaved4(hn::BitCast(pairs, hn::InterleaveLower(d, p0, p1)),
                          hn::BitCast(pairs, hn::InterleaveLower(d, p2, p3)),
                          hn::BitCast(pairs, hn::InterleaveLower(d, p4, p5)),
                          hn::BitCast(pairs, hn::InterleaveLower(d, p6, p7)), pairs, words);
    hn::StoreInterleaved4(hn::BitCast(pairs, hn::InterleaveUpper(d, p0, p1)),
                          hn::BitCast(pairs, hn::InterleaveUpper(d, p2, p3)),
                          hn::BitCast(pairs, hn::InterleaveUpper(d, p4, p5)),
                          hn::BitCast(pairs, hn::InterleaveUpper(d, p6, p7)), pairs, words + 32);
    std::memcpy(numbers + 8 * i, words, sizeof(words));
  }
  join_rest<8>(planes, i, count, numbers);
}

#endif

inline void split_any(const std::byte* numbers, std::size_t count, std::size_t width,
                      std::byte* planes) {
  const auto* const from = reinterpret_cast<const Byte*>(numbers);
  auto* const to = reinterpret_cast<Byte*>(planes);
  width == 2   ? split2(from, count, to)
  : width == 4 ? split4(from, count, to)
               : split8(from, count, to);
}
inline void join_any(const std::byte* planes, std::size_t count, std::size_t width,
                     std::byte* numbers) {
  const auto* const from = reinterpret_cast<const Byte*>(planes);
  auto* const to = reinterpret_cast<Byte*>(numbers);
  width == 2   ? join2(from, count, to)
  : width == 4 ? join4(from, count, to)
               : join8(from, count, to);
}

}  // namespace plait::byte_planes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
