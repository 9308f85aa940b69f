// Computes unit normals of a slot from the grid of its edge, row by row, by the rules of
// normal_rules.h. For float32 records it evaluates them on lanes. Pinned by
// tests/kernels/slot_rows_test.cpp.
#pragma once

#include <cmath>
#include <cstdint>

#include "normals/lanes.h"
#include "normals/normal_rules.h"
#include "plait/kernels/gather_grid.h"
#include "plait/vector3.h"

namespace plait::normals {

/// regular() from the six neighbours of `v`.
inline void regular_at(const Vector3<float>* v, std::int64_t stride, Vector3<float>* to) {
  const Lanes d0 = load(v + stride) - load(v - stride);
  const Lanes d1 = load(v + 1) - load(v - 1);
  const Lanes d2 = load(v + 1 - stride) - load(v + stride - 1);
  const Lanes normal = cross(d0 + 0.5f * (d1 - d2), d1 + d2);
  const Lanes squares = normal * normal;
  const float square = squares[0] + squares[1] + squares[2];
  if (comfortable(square)) [[likely]] {
    constexpr Lanes kZeros{0, 0, 0, 0};  // as kPositiveZeros
    store((1 / std::sqrt(square)) * normal + kZeros, to);
  } else {
    *to = direction(Vector3<float>{normal[0], normal[1], normal[2]});
  }
}
inline void regular_at(const Vector3<double>* v, std::int64_t stride, Vector3<float>* to) {
  *to = regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
}

/// Computes the normals of the slot at `level`. `grid` has the finest level.
template <class Real>
void slot_rows(const EdgeGrid<Vector3<Real>>& grid, int level, bool border,
               Vector3<float>* to) noexcept {
  const std::int64_t stride = grid.stride();
  for_each_slot_row(
      grid, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = border ? n - 1 - row : n;
        for (std::int64_t column = 0; column < inside; ++column, v += step)
          regular_at(v, stride, to++);
        if (border) *to++ = regular_border(*v, v[1 - stride], v[-stride], v[-1], v[stride - 1]);
      });
}

}  // namespace plait::normals
