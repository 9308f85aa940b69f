// Transposes lanes to records, compiled for each instruction set.
#include "execution/fused/half_scatter.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "execution/fused/half_scatter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace plait::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
void scatter_float3(const float* numbers, std::span<const HalfMove> moves, const LanePieces& to) {
  for (const auto& [points, offset] : moves)
    for (std::size_t i = 0; i < kMoveRecords; ++i) {
      const float* from = numbers + std::size_t{points[i]} * 3 * kPatchLanes;
      for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
        const float record[3] = {from[lane], from[kPatchLanes + lane],
                                 from[2 * kPatchLanes + lane]};
        std::memcpy(to[lane] + offset + i * sizeof record, record, sizeof record);
      }
    }
}
#else
/// Stores each block of four numbers of a vector to every fourth lane.
template <class D, class V>
HWY_INLINE void store_blocks(D d, V v, const LanePieces& to, std::size_t lane, std::size_t offset) {
  if constexpr (hn::MaxLanes(D()) == kMoveRecords) {
    hn::StoreU(v, d, reinterpret_cast<float*>(to[lane] + offset));
  } else {
    const hn::Half<D> half;
    store_blocks(half, hn::LowerHalf(half, v), to, lane, offset);
    store_blocks(half, hn::UpperHalf(half, v), to, lane + hn::MaxLanes(half), offset);
  }
}

/// Moves four records of three floats at a time: they are three vectors for each lane.
void scatter_float3(const float* numbers, std::span<const HalfMove> moves, const LanePieces& to) {
  const hn::CappedTag<float, kPatchLanes> d;
  const hn::Repartition<double, decltype(d)> pairs;
  constexpr std::size_t kBlockBytes = kMoveRecords * sizeof(float);
  const auto store = [&](auto v, std::size_t lane, std::size_t offset)
                         HWY_ATTR { store_blocks(d, hn::BitCast(d, v), to, lane, offset); };
  /// Stores the numbers a, b, c and d of each lane one after the other.
  const auto store_four = [&](auto a, auto b, auto c, auto d4, std::size_t lane,
                              std::size_t offset) HWY_ATTR {
    const auto ab_low = hn::BitCast(pairs, hn::InterleaveLower(d, a, b));
    const auto ab_high = hn::BitCast(pairs, hn::InterleaveUpper(d, a, b));
    const auto cd_low = hn::BitCast(pairs, hn::InterleaveLower(d, c, d4));
    const auto cd_high = hn::BitCast(pairs, hn::InterleaveUpper(d, c, d4));
    store(hn::InterleaveLower(pairs, ab_low, cd_low), lane, offset);
    store(hn::InterleaveUpper(pairs, ab_low, cd_low), lane + 1, offset);
    store(hn::InterleaveLower(pairs, ab_high, cd_high), lane + 2, offset);
    store(hn::InterleaveUpper(pairs, ab_high, cd_high), lane + 3, offset);
  };
  for (const HalfMove& move : moves) {
    const auto point = [&](std::size_t i) {
      return numbers + std::size_t{move.points[i]} * 3 * kPatchLanes;
    };
    const float *p0 = point(0), *p1 = point(1), *p2 = point(2), *p3 = point(3);
    constexpr std::size_t y = kPatchLanes, z = 2 * kPatchLanes;
    for (std::size_t lane = 0; lane < kPatchLanes; lane += hn::MaxLanes(d)) {
      const auto load = [&](const float* from) HWY_ATTR { return hn::LoadU(d, from + lane); };
      const std::size_t at = move.offset;
      store_four(load(p0), load(p0 + y), load(p0 + z), load(p1), lane, at);
      store_four(load(p1 + y), load(p1 + z), load(p2), load(p2 + y), lane, at + kBlockBytes);
      store_four(load(p2 + z), load(p3), load(p3 + y), load(p3 + z), lane, at + 2 * kBlockBytes);
    }
  }
}
#endif

}  // namespace plait::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
PLAIT_BEGIN_PRIVATE_NAMESPACE

HWY_EXPORT(scatter_float3);

namespace {

void scatter_any(const HalfOutput& output, const std::byte* numbers,
                 std::span<const HalfMove> moves, const LanePieces& to) {
  for (const auto& [points, offset] : moves)
    for (std::size_t i = 0; i < kMoveRecords; ++i) {
      const std::byte* from = numbers + points[i] * output.record_bytes * kPatchLanes;
      const std::size_t record = offset + i * output.record_bytes;
      for (std::size_t lane = 0; lane < kPatchLanes; ++lane)
        for (std::size_t c = 0; c < output.components; ++c)
          std::memcpy(to[lane] + record + c * output.component_bytes,
                      from + (c * kPatchLanes + lane) * output.component_bytes,
                      output.component_bytes);
    }
}

}  // namespace

void scatter_piece(const HalfOutput& output, const void* points, std::span<const HalfMove> moves,
                   const LanePieces& to) {
  if (output.components == 3 && output.component_bytes == sizeof(float))
    HWY_DYNAMIC_DISPATCH(scatter_float3)(static_cast<const float*>(points), moves, to);
  else
    scatter_any(output, static_cast<const std::byte*>(points), moves, to);
}

PLAIT_END_NAMESPACE
#endif
