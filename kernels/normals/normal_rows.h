// Computes unit normals of a slot from the grid of its edge, row by row, by the rules of
// normal_rules.h. Pinned by tests/kernels/slot_rows_test.cpp.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "normals/normal_rules.h"
#include "plait/detail/gather_grid.h"
#include "plait/extend/vector3.h"

namespace plait::normals {

/// The three numbers of a float32 record at once, and one number that is not used. Each lane has
/// the same IEEE operations as the scalar rules, so the bits are equal.
using Lanes = float __attribute__((vector_size(16)));

/// REQUIRES: the 4 bytes after the record are readable, as they are in an EdgeGrid.
inline Lanes load(const Vector3<float>* record) {
  Lanes lanes;
  std::memcpy(&lanes, record, sizeof(lanes));
  return lanes;
}

/// plait::cross, with the products in the same order.
inline Lanes cross(const Lanes& a, const Lanes& b) {
  const Lanes a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3);
  const Lanes a_zxy = __builtin_shufflevector(a, a, 2, 0, 1, 3);
  const Lanes b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
  const Lanes b_zxy = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  return a_yzx * b_zxy - a_zxy * b_yzx;
}

/// regular() from the six neighbours of `v`.
inline void regular_at(const Vector3<float>* v, std::int64_t stride, Vector3<float>* to) {
  const Lanes d0 = load(v + stride) - load(v - stride);
  const Lanes d1 = load(v + 1) - load(v - 1);
  const Lanes d2 = load(v + 1 - stride) - load(v + stride - 1);
  const Lanes normal = cross(d0 + 0.5f * (d1 - d2), d1 + d2);
  const Lanes squares = normal * normal;
  const float square = squares[0] + squares[1] + squares[2];
  if (RegularNormal::comfortable(square)) [[likely]] {
    constexpr Lanes kZeros{0, 0, 0, 0};  // -0 + 0 = 0
    const Lanes unit = (1 / std::sqrt(square)) * normal + kZeros;
    std::memcpy(to, &unit, sizeof(*to));
  } else {
    *to = regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
  }
}
inline void regular_at(const Vector3<double>* v, std::int64_t stride, Vector3<float>* to) {
  *to = regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
}

/// Computes the normals of the slot at `level`. `grid` has the finest level.
template <class Real>
void slot_rows(const EdgeGrid<Vector3<Real>>& grid, int level, const SlotRows& rows,
               Vector3<float>* to) noexcept {
  const std::int64_t stride = grid.stride();
  for_each_slot_row(
      grid, level,
      [&](std::int64_t row, const Vector3<Real>* v, std::int64_t step, std::int64_t n) {
        const std::int64_t inside = rows.inside(n, row);
        for (std::int64_t column = 0; column < inside; ++column, v += step)
          regular_at(v, stride, to++);
        if (rows.border)
          *to++ = RegularNormal::border(*v, v[1 - stride], v[-stride], v[-1], v[stride - 1]);
      });
}

}  // namespace plait::normals
