// Computes normals of a run of vertices and stores them as records, with the operations of
// normal_rows-inl.h. Included once for each instruction set. Pinned by
// tests/kernels/normals_test.cpp on every instruction set, and by rows_assembly_test.sh.
#if defined(PLAIT_KERNELS_ROWS_RECORD_NORMALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PLAIT_KERNELS_ROWS_RECORD_NORMALS_INL_H
#undef PLAIT_KERNELS_ROWS_RECORD_NORMALS_INL_H
#else
#define PLAIT_KERNELS_ROWS_RECORD_NORMALS_INL_H
#endif

#include <hwy/highway.h>

#include <cstring>

#include "rows/normal_rows-inl.h"
#include "rows/record_normals.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

template <class Real>
void record_row(const RecordNormals<Real>& run) {
  const LaneTag<Real> d;
  const hn::Rebind<float, LaneTag<Real>> narrow;
  const auto one = hn::Set(d, Real(1));
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  float* to = reinterpret_cast<float*>(run.to);
  const auto pair = [&](std::size_t number, std::int64_t at) HWY_ATTR {
    const auto axes = [&](const Vector3<Real>* records) HWY_ATTR {
      Axes<hn::Vec<LaneTag<Real>>> result;
      hn::LoadInterleaved3(d, &records[at].x, result.x, result.y, result.z);
      return result;
    };
    return axes(run.pairs[number][0]) - axes(run.pairs[number][1]);
  };
  for (std::int64_t at = 0; at < run.count; at += lanes, to += 3 * lanes) {
    const std::int64_t left = std::min(run.count - at, lanes);
    const auto towards = regular_cross(d, pair(0, at), pair(1, at), pair(2, at));
    auto square = square_of(towards);
    const auto normal = hn::Div(one, hn::Sqrt(square)) * towards;
    const auto narrowed = [&](auto numbers) HWY_ATTR {  // negative zeros become positive
      if constexpr (sizeof(Real) == sizeof(float))
        return hn::Add(numbers, hn::Zero(narrow));
      else
        return hn::Add(hn::DemoteTo(narrow, numbers), hn::Zero(narrow));
    };
    const auto store_records = [&](float* records) HWY_ATTR {
      hn::StoreInterleaved3(narrowed(normal.x), narrowed(normal.y), narrowed(normal.z), narrow,
                            records);
    };
    if (HWY_LIKELY(left == lanes)) {
      store_records(to);
    } else {
      HWY_ALIGN float last[3 * kPatchLanes];
      store_records(last);
      std::memcpy(to, last, static_cast<std::size_t>(left) * sizeof(*run.to));
      square = hn::IfThenElse(hn::FirstN(d, static_cast<std::size_t>(left)), square, one);
    }
    if (HWY_LIKELY(all_comfortable(d, square))) continue;
    for (std::int64_t lane = at; lane < at + left; ++lane) {
      const auto difference = [&](std::size_t number) {
        return run.pairs[number][0][lane] - run.pairs[number][1][lane];
      };
      run.to[lane] = normals::regular(difference(0), difference(1), difference(2));
    }
  }
}

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
