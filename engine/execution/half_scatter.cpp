// The transposition from lanes to records, for each instruction set.
#include <cstring>

#include "execution/slot_halves.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "execution/half_scatter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace plait::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
void scatter_float3(const float* numbers, std::span<const std::uint32_t> points,
                    const std::array<std::byte*, kPatchLanes>& to, std::size_t offset) {
  for (const std::uint32_t point : points) {
    const float* from = numbers + std::size_t{point} * 3 * kPatchLanes;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const float record[3] = {from[lane], from[kPatchLanes + lane], from[2 * kPatchLanes + lane]};
      std::memcpy(to[lane] + offset, record, sizeof record);
    }
    offset += 3 * sizeof(float);
  }
}
#else
/// Records of three floats are stored as four: the next one, or the room behind the last, takes
/// what is over.
void scatter_float3(const float* numbers, std::span<const std::uint32_t> points,
                    const std::array<std::byte*, kPatchLanes>& to, std::size_t offset) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, kPatchLanes> d;
  const hn::Repartition<double, decltype(d)> pairs;
  constexpr std::size_t kBlockLanes = 4;
  const auto store = [&](auto v, std::size_t lane) HWY_ATTR {
    const auto records = hn::BitCast(d, v);
    const hn::FixedTag<float, kBlockLanes> quad;
    if constexpr (hn::MaxLanes(d) == kBlockLanes) {
      hn::StoreU(records, quad, reinterpret_cast<float*>(to[lane] + offset));
    } else {
      hn::StoreU(hn::LowerHalf(quad, records), quad, reinterpret_cast<float*>(to[lane] + offset));
      hn::StoreU(hn::UpperHalf(quad, records), quad,
                 reinterpret_cast<float*>(to[lane + kBlockLanes] + offset));
    }
  };
  const auto zero = hn::Zero(d);
  for (const std::uint32_t point : points) {
    const float* from = numbers + std::size_t{point} * 3 * kPatchLanes;
    for (std::size_t lane = 0; lane < kPatchLanes; lane += hn::MaxLanes(d)) {
      const auto x = hn::LoadU(d, from + lane), y = hn::LoadU(d, from + kPatchLanes + lane),
                 z = hn::LoadU(d, from + 2 * kPatchLanes + lane);
      const auto xy_low = hn::BitCast(pairs, hn::InterleaveLower(d, x, y));
      const auto xy_high = hn::BitCast(pairs, hn::InterleaveUpper(d, x, y));
      const auto z_low = hn::BitCast(pairs, hn::InterleaveLower(d, z, zero));
      const auto z_high = hn::BitCast(pairs, hn::InterleaveUpper(d, z, zero));
      store(hn::InterleaveLower(pairs, xy_low, z_low), lane);
      store(hn::InterleaveUpper(pairs, xy_low, z_low), lane + 1);
      store(hn::InterleaveLower(pairs, xy_high, z_high), lane + 2);
      store(hn::InterleaveUpper(pairs, xy_high, z_high), lane + 3);
    }
    offset += 3 * sizeof(float);
  }
}
#endif

}  // namespace plait::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plait {

HWY_EXPORT(scatter_float3);

namespace {

void scatter_any(const HalfShape::Output& shape, const std::byte* numbers,
                 std::span<const std::uint32_t> points,
                 const std::array<std::byte*, kPatchLanes>& to) {
  std::size_t offset = shape.offset;
  for (const std::uint32_t point : points) {
    const std::byte* from = numbers + point * shape.record_bytes * kPatchLanes;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane)
      for (std::size_t c = 0; c < shape.components; ++c)
        std::memcpy(to[lane] + offset + c * shape.component_bytes,
                    from + (c * kPatchLanes + lane) * shape.component_bytes, shape.component_bytes);
    offset += shape.record_bytes;
  }
}

}  // namespace

void HalfScatter::operator()(std::size_t output, const void* points, const GroupHalves& to) const {
  const HalfShape::Output& shape = shape_.outputs[output];
  const auto scatter = [&](std::span<const std::uint32_t> path,
                           const std::array<std::byte*, kPatchLanes>& lanes) {
    if (shape.components == 3 && shape.component_bytes == sizeof(float))
      HWY_DYNAMIC_DISPATCH(scatter_float3)
    (static_cast<const float*>(points), path, lanes, shape.offset);
    else scatter_any(shape, static_cast<const std::byte*>(points), path, lanes);
  };
  for (std::size_t side = 0; side < 3; ++side) {
    if (to.sides[side].any_own) scatter(points_[side].own, to.sides[side].own);
    if (to.sides[side].any_other) scatter(points_[side].other, to.sides[side].other);
  }
}

}  // namespace plait
#endif
