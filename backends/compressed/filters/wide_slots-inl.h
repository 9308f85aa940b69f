// The loops of wide_slots.h. Included once for each instruction set.
#if defined(PLAIT_BACKENDS_COMPRESSED_FILTERS_WIDE_SLOTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_BACKENDS_COMPRESSED_FILTERS_WIDE_SLOTS_INL_H
#undef PLAIT_BACKENDS_COMPRESSED_FILTERS_WIDE_SLOTS_INL_H
#else
#define PLAIT_BACKENDS_COMPRESSED_FILTERS_WIDE_SLOTS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "compressed/filters/wide_slots.h"

HWY_BEFORE_NAMESPACE();
namespace plait::wide_slots::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // a vector has no room for a record

constexpr std::size_t kSlots = 0;

#else

using Tag = hn::ScalableTag<std::uint32_t>;
using V = hn::Vec<Tag>;
/// Records in a vector; each has four lanes.
constexpr std::size_t kRecords = hn::MaxLanes(Tag()) / 4;
/// How many vectors are computed side by side.
constexpr std::size_t kVectors = 4;
constexpr std::size_t kSlots = kRecords * kVectors;
static_assert(kSlots <= kMostWideSlots);

HWY_INLINE V signs(V words) {
  const hn::RebindToSigned<Tag> integers;
  return hn::BitCast(Tag(), hn::BroadcastSignBit(hn::BitCast(integers, words)));
}
HWY_INLINE V highest() { return hn::Set(Tag(), 0x80000000u); }
HWY_INLINE V float_to_ordered(V bits) { return hn::Xor(bits, hn::Or(signs(bits), highest())); }
HWY_INLINE V float_from_ordered(V ordered) {
  return hn::Xor(ordered, hn::Or(hn::Not(signs(ordered)), highest()));
}
HWY_INLINE V difference_of(V zigzag) {
  const auto odd = hn::And(zigzag, hn::Set(Tag(), 1));
  return hn::Xor(hn::ShiftRight<1>(zigzag), hn::Sub(hn::Zero(Tag()), odd));
}

/// Rows hold ordered words: the sums need no others.
template <bool kFloat>
struct Lorenzo {
  static HWY_INLINE V form(V bits) { return kFloat ? float_to_ordered(bits) : bits; }
  static HWY_INLINE V bits(V form) { return kFloat ? float_from_ordered(form) : form; }
  static HWY_INLINE V second(V l, V stored) { return hn::Add(l, difference_of(stored)); }
  static HWY_INLINE V along(V l, V, V stored) { return second(l, stored); }
  static HWY_INLINE V inside(V l, V a, V b, V stored) {
    return hn::Add(l, hn::Add(hn::Sub(a, b), difference_of(stored)));
  }
};

struct Parallelogram {
  static HWY_INLINE V form(V bits) { return bits; }
  static HWY_INLINE V bits(V form) { return form; }
  static HWY_INLINE V second(V l, V stored) {
    return float_from_ordered(hn::Add(float_to_ordered(l), difference_of(stored)));
  }
  static HWY_INLINE V along(V l, V k, V stored) { return inside(l, l, k, stored); }
  static HWY_INLINE V inside(V l, V a, V b, V stored) {
    const hn::RebindToFloat<Tag> floats;
    const auto sum =
        hn::Add(hn::BitCast(floats, l), hn::Sub(hn::BitCast(floats, a), hn::BitCast(floats, b)));
    const auto counted = hn::IfThenElseZero(hn::Eq(sum, sum), sum);
    return second(hn::BitCast(Tag(), counted), stored);
  }
};

/// A record of each slot of a vector. Records of three words have a lane that is not used; loading
/// and storing it touches the next record too, unless `exactly`.
template <class D>
HWY_INLINE hn::Vec<D> load(D d, const std::byte* const* from, std::size_t at) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, reinterpret_cast<const std::uint32_t*>(from[0] + at));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, load(half, from + hn::MaxLanes(D()) / 8, at), load(half, from, at));
  }
}
HWY_INLINE V load_exactly(const std::byte* const* from, std::size_t at, std::size_t bytes) {
  HWY_ALIGN std::uint32_t lanes[4 * kRecords] = {};
  for (std::size_t i = 0; i < kRecords; ++i) std::memcpy(lanes + 4 * i, from[i] + at, bytes);
  return hn::Load(Tag(), lanes);
}
template <class D>
HWY_INLINE void store(D d, hn::Vec<D> records, std::byte* const* to, std::size_t at) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    hn::StoreU(records, d, reinterpret_cast<std::uint32_t*>(to[0] + at));
  } else {
    const hn::Half<D> half;
    store(half, hn::LowerHalf(half, records), to, at);
    store(half, hn::UpperHalf(half, records), to + hn::MaxLanes(D()) / 8, at);
  }
}
HWY_INLINE void store_exactly(V records, std::byte* const* to, std::size_t at, std::size_t bytes) {
  HWY_ALIGN std::uint32_t lanes[4 * kRecords];
  hn::Store(records, Tag(), lanes);
  for (std::size_t i = 0; i < kRecords; ++i) std::memcpy(to[i] + at, lanes + 4 * i, bytes);
}

template <class Rule>
void decode(const WideSlots& slots) {
  const Tag d;
  const std::size_t bytes = static_cast<std::size_t>(slots.components) * sizeof(std::uint32_t);
  // Of the last record of a slot, only its own bytes may be touched. Doing so for the last one of
  // each row costs little.
  const std::size_t last = (slots.side - 1) * slots.stride;
  auto* const kept = reinterpret_cast<std::uint32_t*>(slots.row);
  const auto kept_at = [&](std::size_t column, std::size_t v)
                           HWY_ATTR { return kept + (column * kVectors + v) * 4 * kRecords; };
  V l[kVectors], b[kVectors], first[kVectors], above_first[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) {
    l[v] = first[v] = above_first[v] = Rule::form(load_exactly(slots.to + v * kRecords, 0, bytes));
    b[v] = l[v];
    hn::StoreU(l[v], d, kept_at(0, v));
  }
  const auto put = [&](std::size_t v, std::size_t at, bool exactly) HWY_ATTR {
    std::byte* const* const to = slots.to + v * kRecords;
    exactly ? store_exactly(Rule::bits(l[v]), to, at, bytes) : store(d, Rule::bits(l[v]), to, at);
  };
  const auto stored = [&](std::size_t v, std::size_t at, bool exactly) HWY_ATTR {
    const std::byte* const* const from = slots.from + v * kRecords;
    return exactly ? load_exactly(from, at, bytes) : load(d, from, at);
  };
  for (std::size_t column = 1; column < slots.side; ++column) {
    const std::size_t at = column * slots.stride;
    for (std::size_t v = 0; v < kVectors; ++v) {
      const V k = b[v];
      b[v] = l[v];
      const V residual = stored(v, at, at == last);
      l[v] = column == 1 ? Rule::second(l[v], residual) : Rule::along(l[v], k, residual);
      put(v, at, at == last);
      hn::StoreU(l[v], d, kept_at(column, v));
    }
  }
  std::size_t row_at = 0;
  for (std::size_t row = 1; row < slots.side; ++row) {
    row_at += slots.side * slots.stride;
    for (std::size_t v = 0; v < kVectors; ++v) {
      const V residual = stored(v, row_at, false);
      b[v] = first[v];
      l[v] = row == 1 ? Rule::second(b[v], residual) : Rule::along(b[v], above_first[v], residual);
      above_first[v] = b[v];
      first[v] = l[v];
      put(v, row_at, true);
      hn::StoreU(l[v], d, kept_at(0, v));
    }
    const auto decode_column = [&](std::size_t column, bool exactly) HWY_ATTR {
      const std::size_t at = row_at + column * slots.stride;
      for (std::size_t v = 0; v < kVectors; ++v) {
        const V a = hn::LoadU(d, kept_at(column, v));
        l[v] = Rule::inside(l[v], a, b[v], stored(v, at, exactly));
        put(v, at, exactly);
        hn::StoreU(l[v], d, kept_at(column, v));
        b[v] = a;
      }
    };
    for (std::size_t column = 1; column + 1 < slots.side; ++column) decode_column(column, false);
    decode_column(slots.side - 1, true);
  }
}

#endif

inline std::size_t slots_at_once() { return kSlots; }
inline void decode_slots([[maybe_unused]] SlotRule rule, [[maybe_unused]] const WideSlots& slots) {
#if HWY_TARGET != HWY_SCALAR
  switch (rule) {
    case SlotRule::kLorenzoFloat:
      return decode<Lorenzo<true>>(slots);
    case SlotRule::kLorenzoInteger:
      return decode<Lorenzo<false>>(slots);
    case SlotRule::kParallelogram:
      return decode<Parallelogram>(slots);
  }
#endif
}

}  // namespace plait::wide_slots::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PLAIT_BACKENDS_COMPRESSED_FILTERS_WIDE_SLOTS_INL_H
