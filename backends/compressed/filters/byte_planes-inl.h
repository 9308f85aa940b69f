// The loops of byte_planes.h. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
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

HWY_INLINE void differences_rest(const Byte* from, std::size_t first, std::size_t count,
                                 std::size_t distance, Byte* to) {
  for (std::size_t i = first; i < count; ++i)
    to[i] = static_cast<Byte>(from[i] - (i < distance ? 0 : from[i - distance]));
}
HWY_INLINE void sums_rest(const Byte* from, std::size_t first, std::size_t count,
                          std::size_t distance, Byte* to) {
  for (std::size_t i = first; i < count; ++i)
    to[i] = static_cast<Byte>(from[i] + (i < distance ? 0 : to[i - distance]));
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
HWY_INLINE void differences(const Byte* from, std::size_t count, std::size_t distance, Byte* to) {
  differences_rest(from, 0, count, distance, to);
}
HWY_INLINE void sums(const Byte* from, std::size_t count, std::size_t distance, Byte* to) {
  sums_rest(from, 0, count, distance, to);
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

HWY_INLINE void differences(const Byte* from, std::size_t count, std::size_t distance, Byte* to) {
  const hn::ScalableTag<Byte> d;
  std::size_t i = std::min(distance, count);
  std::copy_n(from, i, to);
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d))
    hn::StoreU(hn::Sub(hn::LoadU(d, from + i), hn::LoadU(d, from + i - distance)), d, to + i);
  differences_rest(from, i, count, distance, to);
}

/// Sums over a distance of less than a vector. One step sums `period` bytes, the most whole
/// distances that a vector of 16 bytes has. First it sums the bytes of the step itself: every byte
/// with the one `distance` before it, then every sum with the one twice as far, and so on. Then it
/// adds the sums before the step, which are the last `distance` bytes of the last step. Stores the
/// whole vector; the next step overwrites what follows the period.
HWY_INLINE std::size_t sum_periods(const Byte* from, std::size_t count, std::size_t distance,
                                   Byte* to) {
  const hn::FixedTag<Byte, 16> d;
  const std::size_t period = 16 / distance * distance;
  HWY_ALIGN Byte shift[4][16] = {}, carry[16];
  int shifts = 0;
  for (std::size_t far = distance; far < period; far *= 2, ++shifts)
    for (std::size_t lane = 0; lane < 16; ++lane)
      shift[shifts][lane] = lane < far ? Byte{0x80} : static_cast<Byte>(lane - far);
  for (std::size_t lane = 0; lane < 16; ++lane)
    carry[lane] = static_cast<Byte>(period - distance + lane % distance);
  const auto s0 = hn::Load(d, shift[0]), s1 = hn::Load(d, shift[1]), s2 = hn::Load(d, shift[2]),
             s3 = hn::Load(d, shift[3]), from_last = hn::Load(d, carry);
  auto before = hn::Zero(d);
  std::size_t i = 0;
  const auto run = [&](auto steps) HWY_ATTR {
    for (; i + 16 <= count; i += period) {
      auto sums = hn::LoadU(d, from + i);
      if constexpr (steps > 0) sums = hn::Add(sums, hn::TableLookupBytesOr0(sums, s0));
      if constexpr (steps > 1) sums = hn::Add(sums, hn::TableLookupBytesOr0(sums, s1));
      if constexpr (steps > 2) sums = hn::Add(sums, hn::TableLookupBytesOr0(sums, s2));
      if constexpr (steps > 3) sums = hn::Add(sums, hn::TableLookupBytesOr0(sums, s3));
      sums = hn::Add(sums, hn::TableLookupBytes(before, from_last));
      hn::StoreU(sums, d, to + i);
      before = sums;
    }
  };
  if (shifts == 0) run(std::integral_constant<int, 0>());
  if (shifts == 1) run(std::integral_constant<int, 1>());
  if (shifts == 2) run(std::integral_constant<int, 2>());
  if (shifts == 3) run(std::integral_constant<int, 3>());
  if (shifts == 4) run(std::integral_constant<int, 4>());
  return i;
}

HWY_INLINE void sums(const Byte* from, std::size_t count, std::size_t distance, Byte* to) {
  std::size_t i = 0;
  if (distance < 16) {
    i = sum_periods(from, count, distance, to);
  } else {
    const hn::FixedTag<Byte, 16> d;
    for (; i < std::min(distance, count); ++i) to[i] = from[i];
    for (; i + 16 <= count; i += 16)
      hn::StoreU(hn::Add(hn::LoadU(d, from + i), hn::LoadU(d, to + i - distance)), d, to + i);
  }
  sums_rest(from, i, count, distance, to);
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
inline void differences_any(const std::byte* from, std::size_t count, std::size_t distance,
                            std::byte* to) {
  differences(reinterpret_cast<const Byte*>(from), count, distance, reinterpret_cast<Byte*>(to));
}
inline void sums_any(const std::byte* from, std::size_t count, std::size_t distance,
                     std::byte* to) {
  sums(reinterpret_cast<const Byte*>(from), count, distance, reinterpret_cast<Byte*>(to));
}

}  // namespace plait::byte_planes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_BYTE_PLANES_INL_H
